//! The expression of a hypothesis: checked, then compiled once.

/// Most characters of an expression.
const MOST_CHARACTERS: usize = 1000;
/// Most parentheses that are open at once.
const DEEPEST_NESTING: usize = 32;

/// Most values that wait at once. Between two parentheses at most four do: what of several arguments is done, and an
/// operand each of a sum, a product and a power.
const MOST_WAITING: usize = 4 * (DEEPEST_NESTING + 1);

/// A function of one argument and its name.
type OfOne = (&'static str, fn(f64) -> f64);
/// A function of two arguments, which takes more of them in turn, and its name.
type OfMany = (&'static str, fn(f64, f64) -> f64);

/// Functions of one argument.
const OF_ONE: [OfOne; 16] = [
    ("abs", libm::fabs),
    ("acos", libm::acos),
    ("asin", libm::asin),
    ("atan", libm::atan),
    ("cbrt", libm::cbrt),
    ("cos", libm::cos),
    ("cosh", libm::cosh),
    ("exp", libm::exp),
    ("ln", libm::log),
    ("log10", libm::log10),
    ("sign", sign),
    ("sin", libm::sin),
    ("sinh", libm::sinh),
    ("sqrt", libm::sqrt),
    ("tan", libm::tan),
    ("tanh", libm::tanh),
];

/// Functions of two arguments or more.
const OF_MANY: [OfMany; 2] = [("max", max), ("min", min)];

/// Names that are taken by functions and constants.
pub(super) fn is_taken(name: &str) -> bool {
    name == "pi" || of_one(name).is_some() || of_many(name).is_some()
}

fn of_one(name: &str) -> Option<OfOne> {
    OF_ONE.into_iter().find(|&(known, _)| known == name)
}

fn of_many(name: &str) -> Option<OfMany> {
    OF_MANY.into_iter().find(|&(known, _)| known == name)
}

/// A compiled expression. It has no way to run for long, to remember, or to reach anything outside: it
/// is arithmetic of bounded length.
///
/// ```text
/// + - * / ^ ( )   numbers as 1, 0.5, 2.5e-3   pi   functions f(x), min(x, …), max(x, …)
/// ```
///
/// `^` before `*` and `/` before `+` and `-`, also after a sign: -x^2 is -(x^2). A power of a negative number
/// whose exponent is no integer is odd, (-x)^p = -(x^p): a law of flow then holds both ways. A term without
/// a value, as √-1, is NaN, and NaN stays NaN.
#[derive(Debug, Clone)]
pub(super) struct Expression {
    text: String,
    /// In the order in which it is computed: operands before their operator.
    steps: Vec<Step>,
}

/// A step of a computation with a stack.
#[derive(Debug, Clone, Copy)]
enum Step {
    Number(f64),
    /// By its number.
    Variable(usize),
    OfOne(fn(f64) -> f64),
    OfTwo(fn(f64, f64) -> f64),
}

impl PartialEq for Expression {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text && self.variables().eq(other.variables())
    }
}

/// Why an expression is not accepted, and where: byte in its text.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Refused {
    pub(super) at: usize,
    pub(super) message: String,
}

impl Expression {
    /// Most variables that [`Expression::value`] passes on.
    pub(super) const MOST_VARIABLES: usize = 11;

    /// `variables`: the names that it may use, at most [`Expression::MOST_VARIABLES`]; an empty one keeps a number
    /// without a name.
    pub(super) fn parse(text: &str, variables: &[&str]) -> Result<Self, Refused> {
        Ok(Self {
            text: text.to_owned(),
            steps: Compiler::new(text, variables).compiled()?,
        })
    }

    fn variables(&self) -> impl Iterator<Item = usize> {
        self.steps.iter().filter_map(|step| match step {
            Step::Variable(number) => Some(*number),
            _ => None,
        })
    }

    pub(super) fn text(&self) -> &str {
        &self.text
    }

    /// True if it uses the variable of that number.
    pub(super) fn uses(&self, variable: usize) -> bool {
        self.variables().any(|used| used == variable)
    }

    /// Its value, by the values of all variables.
    pub(super) fn value(&self, values: &[f64; Self::MOST_VARIABLES]) -> f64 {
        let mut waiting = [0.0; MOST_WAITING];
        let mut n_waiting = 0;
        for step in &self.steps {
            match *step {
                Step::Number(number) => {
                    waiting[n_waiting] = number;
                    n_waiting += 1;
                }
                Step::Variable(variable) => {
                    waiting[n_waiting] = values[variable];
                    n_waiting += 1;
                }
                Step::OfOne(apply) => waiting[n_waiting - 1] = apply(waiting[n_waiting - 1]),
                Step::OfTwo(apply) => {
                    n_waiting -= 1;
                    waiting[n_waiting - 1] = apply(waiting[n_waiting - 1], waiting[n_waiting]);
                }
            }
        }
        waiting[0]
    }
}

/// Reads an expression once from its beginning to its end, and writes down its steps.
struct Compiler<'a> {
    text: &'a str,
    variables: &'a [&'a str],
    at: usize,
    steps: Vec<Step>,
    groups: Vec<Group>,
}

/// Text between two parentheses; the first group is the whole expression.
struct Group {
    /// Function of the group.
    function: Function,
    arguments: usize,
    /// True if nothing stands in it (or in the argument) yet.
    is_empty: bool,
    /// Operators that wait for their second operand, each of a higher rank than the one before it.
    waiting: Vec<Operator>,
}

/// Function whose argument a group in parentheses is.
#[derive(Clone, Copy)]
enum Function {
    None,
    OfOne(OfOne),
    OfMany(OfMany),
}

/// An operator and its rank: the higher, the earlier it acts.
#[derive(Clone, Copy)]
struct Operator {
    rank: u8,
    apply: fn(f64, f64) -> f64,
}

const POWER: Operator = Operator {
    rank: 2,
    apply: power,
};

impl Operator {
    fn of(sign: char) -> Option<Self> {
        let (rank, apply): (u8, fn(f64, f64) -> f64) = match sign {
            '+' => (0, |a, b| a + b),
            '-' => (0, |a, b| a - b),
            '*' => (1, |a, b| a * b),
            '/' => (1, |a, b| a / b),
            '^' => return Some(POWER),
            _ => return None,
        };
        Some(Self { rank, apply })
    }
}

impl Group {
    fn new(function: Function) -> Self {
        Self {
            function,
            arguments: 1,
            is_empty: true,
            waiting: Vec::new(),
        }
    }

    /// Writes down the operators that wait and rank no lower than `rank`.
    fn act(&mut self, rank: u8, steps: &mut Vec<Step>) {
        while let Some(last) = self.waiting.pop_if(|last| last.rank >= rank) {
            steps.push(Step::OfTwo(last.apply));
        }
    }

    /// Writes down what is left of an argument.
    fn end_argument(&mut self, steps: &mut Vec<Step>) {
        self.act(0, steps);
        match self.function {
            Function::None => {}
            Function::OfOne((_, apply)) => steps.push(Step::OfOne(apply)),
            // The first has nothing to be taken with.
            Function::OfMany((_, apply)) if self.arguments > 1 => steps.push(Step::OfTwo(apply)),
            Function::OfMany(_) => {}
        }
    }
}

impl<'a> Compiler<'a> {
    fn new(text: &'a str, variables: &'a [&'a str]) -> Self {
        Self {
            text,
            variables,
            at: 0,
            steps: Vec::new(),
            groups: vec![Group::new(Function::None)],
        }
    }

    fn compiled(mut self) -> Result<Vec<Step>, Refused> {
        if self.text.len() > MOST_CHARACTERS {
            return Err(self.refused(format!(
                "{} characters: at most {MOST_CHARACTERS}",
                self.text.chars().count()
            )));
        }
        // Whether a number, a name or a group must come next.
        let mut wants_operand = true;
        while let Some(first) = self.next_character() {
            wants_operand = if wants_operand {
                self.operand(first)?
            } else {
                self.operator(first)?
            };
        }
        if wants_operand {
            return Err(self.refused("ends where a number, a variable or '(' must follow".into()));
        }
        let [whole] = &mut self.groups[..] else {
            return Err(self.refused("ends where ')' must follow".into()));
        };
        whole.end_argument(&mut self.steps);
        Ok(self.steps)
    }

    fn refused(&self, message: String) -> Refused {
        Refused {
            at: self.at,
            message,
        }
    }

    /// The next character that is no blank.
    fn next_character(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    /// Takes what comes where an operand must; returns whether one must still come.
    fn operand(&mut self, first: char) -> Result<bool, Refused> {
        let is_empty = self.groups.last().is_some_and(|group| group.is_empty);
        match first {
            '(' => {
                self.open(Function::None)?;
                self.at += 1;
                return Ok(true);
            }
            '+' | '-' if is_empty => {
                // As a difference from 0, a sign acts on the whole product after it.
                self.begin();
                self.steps.push(Step::Number(0.0));
                return self.operator(first);
            }
            '+' | '-' => {
                return Err(self.refused(format!(
                    "'{first}' after an operator: write the operand in parentheses, as in a * (-b)"
                )));
            }
            '0'..='9' | '.' => self.number()?,
            'a'..='z' | 'A'..='Z' | '_' => return self.name(),
            _ => return Err(self.refused(self.unexpected(first, "a number, a variable or '('"))),
        }
        self.begin();
        Ok(false)
    }

    /// Takes what comes where an operator must; returns whether an operand must come next.
    fn operator(&mut self, first: char) -> Result<bool, Refused> {
        let accepted = "an operator (+ - * / ^) or the end";
        let refusal = self.refused(self.unexpected(first, accepted));
        let in_parentheses = self.groups.len() > 1;
        let Some(group) = self.groups.last_mut() else {
            return Err(refusal);
        };
        let mut wants_operand = true;
        match (first, group.function) {
            ('^', _)
                if group
                    .waiting
                    .last()
                    .is_some_and(|last| last.rank == POWER.rank) =>
            {
                let message = "a power of a power: write (a^b)^c or a^(b^c)".into();
                return Err(Refused { message, ..refusal });
            }
            (',', Function::OfMany(_)) => {
                group.end_argument(&mut self.steps);
                group.arguments += 1;
                group.is_empty = true;
            }
            (')', function) if in_parentheses => {
                if let (Function::OfMany((name, _)), 1) = (function, group.arguments) {
                    let message = format!("{name} needs at least 2 arguments");
                    return Err(Refused { message, ..refusal });
                }
                group.end_argument(&mut self.steps);
                self.groups.pop();
                wants_operand = false;
            }
            _ => {
                let operator = Operator::of(first).ok_or(refusal)?;
                group.act(operator.rank, &mut self.steps);
                group.waiting.push(operator);
            }
        }
        self.at += 1;
        Ok(wants_operand)
    }

    fn unexpected(&self, found: char, accepted: &str) -> String {
        format!("'{}': must be {accepted}", found.escape_default())
    }

    /// Notes that something stands in the current group.
    fn begin(&mut self) {
        if let Some(group) = self.groups.last_mut() {
            group.is_empty = false;
        }
    }

    fn open(&mut self, function: Function) -> Result<(), Refused> {
        self.begin();
        if self.groups.len() > DEEPEST_NESTING {
            return Err(self.refused(format!("parentheses nested deeper than {DEEPEST_NESTING}")));
        }
        self.groups.push(Group::new(function));
        Ok(())
    }

    fn number(&mut self) -> Result<(), Refused> {
        let rest = &self.text[self.at..];
        let Some(number) = literal(rest) else {
            return Err(self.refused(self.unexpected('.', "a number, a variable or '('")));
        };
        match number.parse::<f64>() {
            Ok(value) if value.is_finite() => self.steps.push(Step::Number(value)),
            _ => return Err(self.refused(format!("{number}: must be a finite number"))),
        }
        self.at += number.len();
        Ok(())
    }

    /// Takes a variable, the constant or the name of a function with its parenthesis.
    fn name(&mut self) -> Result<bool, Refused> {
        let rest = &self.text[self.at..];
        let length = rest
            .find(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))
            .unwrap_or(rest.len());
        let name = &rest[..length];
        let after = rest[length..].trim_start();
        if after.starts_with('(') {
            if let Some(function) = of_many(name) {
                self.open(Function::OfMany(function))?;
            } else if let Some(function) = of_one(name) {
                self.open(Function::OfOne(function))?;
            } else {
                let known = OF_ONE.iter().map(|&(known, _)| known);
                let known: Vec<&str> = known.chain(OF_MANY.map(|(known, _)| known)).collect();
                return Err(self.refused(format!(
                    "'{name}(': no such function; known are {}",
                    known.join(" ")
                )));
            }
            self.at += rest.len() - after.len() + 1;
            return Ok(true);
        }
        if name == "pi" {
            self.steps.push(Step::Number(core::f64::consts::PI));
        } else if let Some(number) = self.variables.iter().position(|&known| known == name) {
            self.steps.push(Step::Variable(number));
        } else {
            let known: Vec<&str> = self
                .variables
                .iter()
                .copied()
                .filter(|v| !v.is_empty())
                .collect();
            return Err(self.refused(format!(
                "'{name}': no such variable; known are {} pi",
                known.join(" ")
            )));
        }
        self.at += length;
        self.begin();
        Ok(false)
    }
}

/// The number that a text begins with: digits, a point, an exponent; no sign.
fn literal(text: &str) -> Option<&str> {
    let digits = |from: usize| {
        let rest = text.get(from..).unwrap_or("");
        rest.bytes().take_while(u8::is_ascii_digit).count()
    };
    let whole = digits(0);
    let mut length = whole;
    if text[length..].starts_with('.') {
        let places = digits(length + 1);
        if whole + places == 0 {
            return None;
        }
        length += 1 + places;
    }
    if length == 0 {
        return None;
    }
    if text[length..].starts_with(['e', 'E']) {
        let signed = text[length + 1..].starts_with(['+', '-']);
        let start = length + 1 + usize::from(signed);
        let exponent = digits(start);
        if exponent > 0 {
            length = start + exponent;
        }
    }
    Some(&text[..length])
}

/// x^p; odd in x where p is no integer.
fn power(x: f64, p: f64) -> f64 {
    if x.is_nan() {
        x
    } else if x < 0.0 && libm::floor(p) < p {
        -libm::pow(-x, p)
    } else {
        libm::pow(x, p)
    }
}

fn sign(x: f64) -> f64 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else {
        x
    }
}

fn max(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

fn min(a: f64, b: f64) -> f64 {
    if a.is_nan() || a < b { a } else { b }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{Expression, Step};

    const VARIABLES: [&str; 3] = ["x", "minor", "E"];

    fn value(text: &str) -> f64 {
        let mut values = [0.0; Expression::MOST_VARIABLES];
        values[..3].copy_from_slice(&[2.0, 5.0, 7.0]);
        match Expression::parse(text, &VARIABLES) {
            Ok(expression) => expression.value(&values),
            Err(refused) => unreachable!("{text}: {refused:?}"),
        }
    }

    impl Expression {
        /// Values that are left after the last step; `None` if an operator lacks one.
        fn left(&self) -> Option<usize> {
            self.steps
                .iter()
                .try_fold(0_usize, |left, step| match step {
                    Step::Number(_) | Step::Variable(_) => Some(left + 1),
                    Step::OfOne(_) => (left > 0).then_some(left),
                    Step::OfTwo(_) => (left > 1).then(|| left - 1),
                })
        }
    }

    fn refusal(text: &str) -> String {
        match Expression::parse(text, &VARIABLES) {
            Ok(_) => unreachable!("{text}"),
            Err(refused) => format!("{}: {}", refused.at, refused.message),
        }
    }

    #[test]
    fn it_is_read_as_on_the_page() {
        for (text, expected) in [
            ("-x^2", -4.0),
            ("3 * (-x^2)", -12.0),
            ("8 - 3 + 2", 7.0),
            ("8 - 3 - 2", 3.0),
            ("8 / 4 * 2", 4.0),
            ("2 + 3 * x ^ 2", 14.0),
            ("-x * 3 + 1", -5.0),
            ("+x", 2.0),
            ("2^(-1)", 0.5),
            ("(2^3)^2", 64.0),
            ("2^(3^2)", 512.0),
            ("1e-3 * 1.5E3 + .5 + 2.", 4.0),
            ("E", 7.0),
            ("minor - x", 3.0),
            ("min(minor, max(1, x), 3)^2", 4.0),
            ("max(-x, min(x, 1) - 3, -4)", -2.0),
            ("sqrt(x + 2) + abs(-3)", 5.0),
            ("sign(-x) + sign(0) + sign(x)", 0.0),
            ("cos(0) + exp(0) + ln(1)", 2.0),
            ("sin(pi/2)", 1.0),
            ("(0 - 8)^(1/3)", -2.0),
            ("(0 - x)^3", -8.0),
            ("(((x)))", 2.0),
        ] {
            assert!((value(text) - expected).abs() < 1e-15, "{text}");
        }
        for text in [
            "sqrt(-x)",
            "ln(-1)",
            "0/0",
            "max(0/0, 1)",
            "min(1, 0/0)",
            "(0/0)^0",
        ] {
            assert!(value(text).is_nan(), "{text}");
        }
    }

    #[test]
    fn what_is_no_expression_is_refused_with_its_place() {
        let operand = "must be a number, a variable or '('";
        for (text, expected) in [
            ("", "0: ends where a number, a variable or '(' must follow".to_owned()),
            ("x +", "3: ends where a number, a variable or '(' must follow".to_owned()),
            ("(x", "2: ends where ')' must follow".to_owned()),
            ("x)", "1: ')': must be an operator (+ - * / ^) or the end".to_owned()),
            ("2x", "1: 'x': must be an operator (+ - * / ^) or the end".to_owned()),
            ("x = 1", "2: '=': must be an operator (+ - * / ^) or the end".to_owned()),
            ("x; 1", "1: ';': must be an operator (+ - * / ^) or the end".to_owned()),
            ("()", format!("1: ')': {operand}")),
            ("{x}", format!("0: '{{': {operand}")),
            ("ä", format!("0: '\\u{{e4}}': {operand}")),
            (".", format!("0: '.': {operand}")),
            ("x * -1", "4: '-' after an operator: write the operand in parentheses, as in a * (-b)".to_owned()),
            ("2^3^x", "3: a power of a power: write (a^b)^c or a^(b^c)".to_owned()),
            ("min(x)", "5: min needs at least 2 arguments".to_owned()),
            ("sin(x, 1)", "5: ',': must be an operator (+ - * / ^) or the end".to_owned()),
            ("q + 1", "0: 'q': no such variable; known are x minor E pi".to_owned()),
            ("sin + 1", "0: 'sin': no such variable; known are x minor E pi".to_owned()),
            (
                "system(x)",
                "0: 'system(': no such function; known are abs acos asin atan cbrt cos cosh exp ln log10 sign \
                 sin sinh sqrt tan tanh max min".to_owned(),
            ),
            ("1e999", "0: 1e999: must be a finite number".to_owned()),
        ] {
            assert_eq!(refusal(text), expected, "{text}");
        }
    }

    #[test]
    fn length_and_nesting_are_bounded() {
        let deep = |count: usize| format!("{}x{}", "(".repeat(count), ")".repeat(count));
        assert_eq!(
            refusal(&deep(100_000)),
            "0: 200001 characters: at most 1000"
        );
        assert_eq!(refusal(&deep(33)), "32: parentheses nested deeper than 32");
        assert!((value(&deep(32)) - 2.0).abs() < 1e-15);
        // As many values wait as can: 1 + 1 · 1^(…), and a max before each.
        let waits = format!("{}2{}", "max(1,1+1*1^(".repeat(16), "))".repeat(16));
        assert!((value(&waits) - 2.0).abs() < 1e-15);
        let long = vec!["x"; 500].join("+");
        assert!((value(&long) - 1000.0).abs() < 1e-12);
    }

    const WORDS: [&str; 24] = [
        "x", "minor", "E", "pi", "2", ".5", "1e-3", "0", "+", "-", "*", "/", "^", "(", ")", ",",
        " ", "min(", "max(", "sin(", "sqrt(", "ln(", "(", ")",
    ];

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(3000) })]

        /// Whatever the words: what is read has a value, and as many operands as its operators take.
        #[test]
        fn what_is_read_has_a_value(
            words in proptest::collection::vec(proptest::sample::select(&WORDS[..]), 1..14),
            closed in 0usize..6,
        ) {
            let text = words.concat() + &")".repeat(closed);
            if let Ok(expression) = Expression::parse(&text, &VARIABLES) {
                prop_assert_eq!(expression.left(), Some(1), "{}", text);
                value(&text);
            }
        }

        #[test]
        fn any_text_is_read_or_refused(text in "\\PC{0,60}") {
            let _ = Expression::parse(&text, &VARIABLES);
        }
    }
}
