"""What is missing in the model of your rig: drop recordings, read the verdict, move the drive.

    pip install 'sma-actuator[all]' marimo
    marimo run app.py

As a script (``python app.py``) it diagnoses the demonstration.
"""

import marimo

__generated_with = "0.25.2"
app = marimo.App(width="medium", app_title="sma")


@app.cell
def _():
    import re
    import tempfile
    from pathlib import Path

    import marimo as mo
    import numpy as np

    import sma

    return Path, mo, np, re, sma, tempfile


@app.cell
def _(mo):
    mo.md("""
    # What is missing in the model of your rig?

    Drop recordings of drive and output, as your logger wrote them. Those for training are fitted; unseen ones test the fit.
    Without any, the demonstration is shown: a simulated wire, with physics that the program is not told.
    """)
    return


@app.cell
def _(mo):
    _kinds = [".csv", ".txt", ".tsv", ".lvm", ".mat", ".h5", ".tdms", ".xlsx", ".parquet", ".feather", ".npz", ".npy"]
    training = mo.ui.file(filetypes=_kinds, multiple=True, kind="area", label="Training")
    unseen = mo.ui.file(filetypes=_kinds, multiple=True, kind="area", label="Unseen")
    mo.hstack([training, unseen], widths="equal")
    return training, unseen


@app.cell
def _(Path, mo, sma, tempfile, training, unseen):
    folder = Path(tempfile.mkdtemp(prefix="sma-app-"))

    def _kept(files, role):
        kept = []
        for file in files:
            place = folder / role / Path(file.name).name
            # Files of several folders may have the same name.
            place = place.with_name(f"{len(kept)}-{place.name}") if place in kept else place
            place.parent.mkdir(exist_ok=True)
            place.write_bytes(file.contents)
            kept.append(place)
        return kept

    try:
        if training.value:
            recordings = {"train": _kept(training.value, "train"), "validate": _kept(unseen.value, "unseen")}
            first_rod = sma.init(recordings["train"])
        else:
            demo = sma.demo(folder)
            recordings = {"train": [demo.train], "validate": [demo.unseen]}
            first_rod = demo.rod.read_text(encoding="utf-8")
    except sma.SmaError as _error:
        mo.stop(True, mo.callout(str(_error), kind="danger"))
    return first_rod, folder, recordings


@app.cell
def _(first_rod, mo):
    rod_text = mo.ui.text_area(value=first_rod, rows=18, full_width=True, label="What is known of the rod: rod.toml")
    mo.output.append(rod_text)
    return (rod_text,)


@app.cell
def _(folder, mo, recordings, rod_text, sma):
    rod = folder / "rod.toml"
    rod.write_text(rod_text.value, encoding="utf-8")
    try:
        inspected = sma.inspect([*recordings["train"], *recordings["validate"]], rod)
    except sma.SmaError as _error:
        mo.stop(True, mo.callout(str(_error), kind="danger"))
    mo.accordion({"What the recordings can tell": mo.Html(inspected._repr_html_())})
    return inspected, rod


@app.cell
def _(mo):
    effort = mo.ui.dropdown(["quick", "normal", "thorough"], value="normal", label="Effort")
    begin = mo.ui.run_button(label="Say what is missing")
    mo.hstack([effort, begin], justify="start")
    return begin, effort


@app.cell
def _(begin, effort, inspected, mo, recordings, rod, sma):
    _asked = begin.value or mo.app_meta().mode in ("script", None)
    mo.stop(not _asked or not inspected.recordings, mo.md("Seconds for a short recording, half a minute for a long one."))
    with mo.status.spinner(title="Fitting, and looking for what is missing") as _spinner:
        try:
            found = sma.diagnose(
                rod,
                recordings["train"],
                recordings["validate"] or None,
                effort=effort.value,
                progress=lambda line: _spinner.update(subtitle=line),
            )
        except sma.SmaError as _error:
            mo.stop(True, mo.callout(str(_error), kind="danger"))
    return (found,)


@app.cell
def _(found, mo):
    _said = "\n".join(f"- {one.sentence}" for one in found.findings) or "Nothing was found."
    _share = f"\n\n{found.explained_fraction:.0%} of the explainable error is explained." if found.explained_fraction else ""
    mo.vstack(
        [
            mo.callout(
                mo.md(f"**{found.verdict or 'not to be used'}**\n\n{_said}{_share}"),
                kind="success" if found.findings else "neutral",
            ),
            mo.accordion(
                {
                    "Report, with figures": mo.iframe(found.report, height="800px"),
                    "As the terminal says it": mo.plain_text(found.text),
                }
            ),
        ]
    )
    return


@app.cell
def _(found, mo, re, sma):
    _drives = {"A": "current_a", "1": "duty", "V": "voltage_v", "W": "power_w"}
    mo.stop(found.model is None or not found.series or found.series[0].drive_unit not in _drives, mo.md(""))
    # A profile that is made here has the usual columns, whatever those of the recordings are called.
    model = sma.Model(re.sub(r"(?ms)^\[columns.*?(?=^\[(?!columns))", "", found.model.toml))
    drive_column = _drives[found.series[0].drive_unit]
    _most = round(max(float(one.drive.max()) for one in found.series), 3)
    level = mo.ui.slider(0.0, _most, step=0.001, value=round(0.7 * _most, 3), label=drive_column, show_value=True)
    heated_s = mo.ui.slider(1, 120, value=30, label="Heated for, s", show_value=True)
    mo.vstack([mo.md("## What the rig would do"), mo.hstack([level, heated_s], justify="start")])
    return drive_column, heated_s, level, model


@app.cell
def _(drive_column, found, heated_s, level, model, np, sma):
    _dt_s = float(np.median(np.diff(found.series[0].time_s)))
    _time_s = np.arange(0.0, 2.0 * heated_s.value + 10.0, _dt_s)
    _is_heated = (_time_s >= 5.0) & (_time_s < 5.0 + heated_s.value)
    predicted = sma.simulate(model, {"time_s": _time_s, drive_column: np.where(_is_heated, level.value, 0.0)})
    predicted.plot()
    return


@app.cell
def _(found, mo, model):
    _stroke = max(float(one.output.max() - one.output.min()) for one in found.series)
    step_output = mo.ui.number(value=float(f"{0.5 * _stroke:.2g}"), label=f"Step, {found.output_unit}")
    propose = mo.ui.run_button(label="Propose gains")
    mo.stop(model is None)
    mo.vstack([mo.md("## A controller"), mo.hstack([step_output, propose], justify="start")])
    return propose, step_output


@app.cell
def _(found, mo, model, propose, sma, step_output):
    mo.stop(not propose.value)
    try:
        with mo.status.spinner(title="Looking for gains with margins"):
            controller = sma.tune(
                model, step_output=step_output.value, drive_max=max(float(one.drive.max()) for one in found.series)
            )
    except sma.SmaError as _error:
        mo.stop(True, mo.callout(str(_error), kind="danger"))
    mo.vstack([mo.md(f"`{controller.gains}`"), controller.plot()])
    return


if __name__ == "__main__":
    app.run()
