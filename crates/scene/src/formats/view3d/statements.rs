//! The statements of a .vs3 file.
//!
//! Each begins with a letter on a line of its own. Blanks, commas and tabs separate words; `!` and `/` before a word
//! begin a comment; a `*`, or a line that begins with E, ends the file.

use glam::DVec3;

use super::Fault;
use super::planes::Plane;
use crate::formats::mesh::is_coordinate;

/// What a file says.
#[derive(Debug, Default)]
pub(super) struct Document {
    pub controls: Controls,
    /// Surfaces of all kinds; number n is at n - 1.
    pub entries: Vec<Entry>,
    /// The first line that begins with something else.
    pub unknown: Option<(usize, String)>,
}

/// The lines `C`. Numbers of surfaces are those of the file, 0 for all.
#[derive(Debug, Default)]
pub(super) struct Controls {
    pub tolerance: Option<f64>,
    pub enclosure: bool,
    pub emissivity: bool,
    pub row: usize,
    pub column: usize,
    /// What was ignored, as `name=value`.
    pub ignored: Vec<String>,
}

/// The kinds of surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Radiating,
    Obstruction,
    Null,
}

/// A surface of any kind. Numbers of surfaces are those of the file, 0 for none.
#[derive(Debug)]
pub(super) struct Entry {
    pub line: usize,
    pub kind: Kind,
    /// Three or four.
    pub corners: Vec<DVec3>,
    pub base: usize,
    pub combined: usize,
    pub emissivity: f64,
    pub name: String,
}

/// Reads all statements.
pub(super) fn read(text: &str) -> Result<Document, Fault> {
    let mut reader = Reader { lines: Lines::new(text), ..Reader::default() };
    while let Some(statement) = reader.lines.next_statement() {
        let line = statement.line;
        reader.statement(statement).map_err(|message| Fault { line: reader.lines.number.max(line), message })?;
        if reader.is_done {
            break;
        }
    }
    Ok(reader.document)
}

/// The words of a line.
struct Statement<'a> {
    line: usize,
    words: Vec<&'a str>,
}

/// Lines with words on them.
#[derive(Default)]
struct Lines<'a> {
    lines: Option<std::str::Lines<'a>>,
    /// The number of the last line, from 1.
    number: usize,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str) -> Self {
        Self { lines: Some(text.strip_prefix('\u{feff}').unwrap_or(text).lines()), number: 0 }
    }

    /// The next line that has words, without its comment.
    fn next_statement(&mut self) -> Option<Statement<'a>> {
        loop {
            let line = self.lines.as_mut()?.next()?;
            self.number += 1;
            let words = line.split([' ', ',', '\t', '\r', '\0']).filter(|word| !word.is_empty());
            let words: Vec<_> = words.take_while(|word| !word.starts_with(['!', '/'])).collect();
            if !words.is_empty() {
                return Some(Statement { line: self.number, words });
            }
        }
    }
}

#[derive(Default)]
struct Reader<'a> {
    lines: Lines<'a>,
    document: Document,
    vertices: Vec<DVec3>,
    /// Whether surfaces are given by planes.
    has_planes: bool,
    is_done: bool,
}

impl Reader<'_> {
    fn statement(&mut self, statement: Statement) -> Result<(), String> {
        let Statement { line, words } = statement;
        let letter = words[0].chars().next().unwrap_or_default().to_ascii_uppercase();
        match letter {
            'T' | 'X' => {}
            'C' => self.control(&words[1..])?,
            'F' => self.form(&words[1..])?,
            'V' => self.vertex(&words[1..])?,
            'S' => self.surface(line, Kind::Radiating, &words[1..])?,
            'O' => self.surface(line, Kind::Obstruction, &words[1..])?,
            'N' => self.surface(line, Kind::Null, &words[1..])?,
            'M' => {
                let message = "masking surfaces are not modelled; begin the line with N instead of M and scale the \
                               factors from the base by the areas, or leave it out";
                return Err(message.into());
            }
            'E' | '*' => self.is_done = true,
            _ => {
                self.document.unknown.get_or_insert((line, words[0].chars().take(20).collect()));
            }
        }
        Ok(())
    }

    fn form(&mut self, words: &[&str]) -> Result<(), String> {
        let form = words.first().copied().unwrap_or_default();
        if !self.document.entries.is_empty() {
            return Err("the line F must come before all surfaces".into());
        }
        self.has_planes = match form.to_ascii_lowercase().as_str() {
            "3" => false,
            "3a" => true,
            "2" => return Err("the file describes a 2-D geometry (F 2); only F 3 and F 3a are read".into()),
            _ => return Err(format!("there is no form '{form}'; F 3 and F 3a are read")),
        };
        Ok(())
    }

    fn control(&mut self, words: &[&str]) -> Result<(), String> {
        let mut parts = words.iter().flat_map(|word| word.split('=')).filter(|part| !part.is_empty());
        while let Some(name) = parts.next() {
            let controls = &mut self.document.controls;
            let mut value = || parts.next().ok_or_else(|| format!("'{name}' has no value; write {name}=1 or the like"));
            match name.to_ascii_lowercase().as_str() {
                "eps" => controls.tolerance = Some(positive(value()?)?),
                "encl" => controls.enclosure = integer(value()?)? != 0,
                "emit" => controls.emissivity = integer(value()?)? != 0,
                "row" => controls.row = usize::try_from(integer(value()?)?).unwrap_or(0),
                "col" => controls.column = usize::try_from(integer(value()?)?).unwrap_or(0),
                _ => {
                    let ignored = parts.next().map_or(name.to_string(), |value| format!("{name}={value}"));
                    controls.ignored.push(ignored.chars().take(40).collect());
                }
            }
        }
        Ok(())
    }

    fn vertex(&mut self, words: &[&str]) -> Result<(), String> {
        let [number, coordinates @ ..] = words else { return Err("a vertex needs a number and x, y, z".into()) };
        in_sequence("vertex", number, self.vertices.len())?;
        if coordinates.len() < 3 {
            return Err(format!("vertex {number} has {} coordinates; it needs x, y and z", coordinates.len()));
        }
        let [x, y, z] = [0, 1, 2].map(|axis| coordinate(coordinates[axis]));
        self.vertices.push(DVec3::new(x?, y?, z?));
        Ok(())
    }

    fn surface(&mut self, line: usize, kind: Kind, words: &[&str]) -> Result<(), String> {
        let [number, words @ ..] = words else { return Err("a surface needs a number".into()) };
        in_sequence("surface", number, self.document.entries.len())?;
        // A shape stands in place of the four vertices if planes are given.
        let (before, needed) = if self.has_planes { (1, 1) } else { (4, 4) };
        let needed = if kind == Kind::Obstruction { needed } else { before + 3 };
        if words.len() < needed {
            let what = if self.has_planes { "a shape" } else { "four vertices" };
            let rest = if kind == Kind::Obstruction { "" } else { ", base, combination and emissivity" };
            return Err(format!("the surface has too few numbers; it needs {what}{rest}"));
        }
        let (base, combined, emissivity) = match kind {
            Kind::Obstruction => (0, 0, 1.0),
            _ => (surface(words[before])?, surface(words[before + 1])?, emissivity(words[before + 2])?),
        };
        if kind == Kind::Null && combined > 0 {
            return Err("a null surface cannot be combined; write 0".into());
        }
        let name = words.get(before + 3).map_or_else(|| format!("{} {number}", label(kind)), |name| name.to_string());
        let corners = if self.has_planes { self.figure(words[0])? } else { self.corners(&words[..4])? };
        self.document.entries.push(Entry { line, kind, corners, base, combined, emissivity, name });
        Ok(())
    }

    /// The corners with these numbers; 0 at the end makes a triangle.
    fn corners(&self, words: &[&str]) -> Result<Vec<DVec3>, String> {
        let used = if words[3] == "0" { &words[..3] } else { words };
        let corner = |word: &&str| {
            let place = word.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
            place.and_then(|place| self.vertices.get(place)).copied().ok_or_else(|| {
                format!("it refers to vertex '{word}' of {}; vertices come first and count from 1", self.vertices.len())
            })
        };
        used.iter().map(corner).collect()
    }

    /// The corners of a figure in a plane, whose numbers are on the following lines.
    fn figure(&mut self, shape: &str) -> Result<Vec<DVec3>, String> {
        let more = match shape.to_ascii_uppercase().as_str() {
            "R" => 2,
            "T" => 6,
            "Q" => 8,
            _ => return Err(format!("there is no shape '{shape}'; it is R, T or Q")),
        };
        let mut numbers = Vec::new();
        while numbers.len() < 5 + more {
            let Some(statement) = self.lines.next_statement() else {
                return Err("the file ends within a surface; it was cut short".into());
            };
            for word in statement.words {
                numbers.push(coordinate(word)?);
            }
        }
        let plane = Plane::new(DVec3::new(numbers[0], numbers[1], numbers[2]), numbers[3], numbers[4]);
        let figure = &numbers[5..5 + more];
        let outline = match *figure {
            [width, height] => vec![[0.0, height], [0.0, 0.0], [width, 0.0], [width, height]],
            _ => figure.as_chunks::<2>().0.to_vec(),
        };
        Ok(outline.into_iter().map(|[x, y]| plane.at(x, y)).collect())
    }
}

fn label(kind: Kind) -> &'static str {
    match kind {
        Kind::Radiating => "surface",
        Kind::Obstruction => "obstruction",
        Kind::Null => "null surface",
    }
}

fn in_sequence(what: &str, number: &str, before: usize) -> Result<(), String> {
    if number.parse() == Ok(before + 1) {
        return Ok(());
    }
    Err(format!("{what} '{number}' is out of sequence; it must be number {}", before + 1))
}

/// The number of a surface, 0 for none.
fn surface(word: &str) -> Result<usize, String> {
    word.parse().map_err(|_| format!("'{word}' is not the number of a surface; write 0 for none"))
}

fn emissivity(word: &str) -> Result<f64, String> {
    let number = word.parse().ok().filter(|number| (0.0..=1.0).contains(number));
    number.ok_or_else(|| format!("'{word}' is not an emissivity; it must be at least 0 and at most 1"))
}

fn coordinate(word: &str) -> Result<f64, String> {
    let number = word.parse().ok().filter(|&number| is_coordinate(number));
    number.ok_or_else(|| format!("'{word}' is not a finite number; repair the file"))
}

fn positive(word: &str) -> Result<f64, String> {
    let number = word.parse().ok().filter(|&number: &f64| number > 0.0 && number.is_finite());
    number.ok_or_else(|| format!("'{word}' is not a positive number"))
}

fn integer(word: &str) -> Result<i64, String> {
    word.parse().map_err(|_| format!("'{word}' is not a whole number"))
}
