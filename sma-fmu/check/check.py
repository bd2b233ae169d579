"""Checks a functional mock-up unit with FMPy, and compares it with `sma simulate`, bit for bit.

    sma export model.toml --to fmu --output rod.fmu      (or --to fmu3)
    sma simulate model.toml --drive profile.csv --output predicted.csv
    python check.py rod.fmu predicted.csv

The profile has no output; its surroundings are those that the model states.
"""

import csv
import shutil
import sys

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu


def main(unit, predicted):
    problems = validate_fmu(unit)
    if problems:
        sys.exit("\n".join([f"{unit}: FMPy reports problems:", *problems]))
    with open(predicted, newline="") as file:
        header, *rows = csv.reader(line for line in file if not line.startswith("#"))
    time_s = [float(row[0]) for row in rows]
    drive = [float(row[1]) for row in rows]
    expected = [tuple(float(value) for value in row[2:4]) for row in rows]
    # As the program has it for equal steps.
    step_s = (time_s[-1] - time_s[0]) / (len(rows) - 1)
    description = fmpy.read_model_description(unit)
    reference = {variable.name: variable.valueReference for variable in description.modelVariables}
    shown = [reference["displacement"], reference["temperature_degc"]]
    folder = fmpy.extract(unit)
    is_of_version_3 = description.fmiVersion.startswith("3")
    slave = (FMU3Slave if is_of_version_3 else FMU2Slave)(
        guid=description.guid or description.instantiationToken,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="rod",
    )
    slave.instantiate()
    if is_of_version_3:
        slave.enterInitializationMode(startTime=time_s[0])
        get, set_to = slave.getFloat64, slave.setFloat64
    else:
        slave.setupExperiment(startTime=time_s[0])
        slave.enterInitializationMode()
        get, set_to = slave.getReal, slave.setReal
    slave.exitInitializationMode()
    differing = 0
    for k, value in enumerate(drive):
        differing += tuple(get(shown)) != expected[k]
        set_to([reference["drive"]], [value])
        slave.doStep(time_s[k], step_s)
    slave.terminate()
    slave.freeInstance()
    shutil.rmtree(folder, ignore_errors=True)
    if differing:
        sys.exit(f"{unit}: {differing} of {len(rows)} samples differ from {predicted}")
    print(f"{unit}: FMPy {fmpy.__version__} reports no problems; {len(rows)} samples have the bits of {predicted}")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("expected a unit and a prediction: check.py rod.fmu predicted.csv")
    main(*sys.argv[1:])
