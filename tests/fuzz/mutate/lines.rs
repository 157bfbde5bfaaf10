//! Tables, and other texts of lines of cells.

use rand::RngExt;

use super::{NUMBERS, any, places, value};
use crate::input::Random;

/// The most copies of a line.
const MAX_COPIES: usize = 300;

/// A text that is changed at a few places.
pub(crate) fn mutated(
    text: &str,
    separator: char,
    words: &[String],
    random: &mut Random,
) -> String {
    let mut lines: Vec<String> = text.lines().map(Into::into).collect();
    for _ in 0..places(random) {
        if lines.is_empty() {
            break;
        }
        mutate(&mut lines, separator, words, random);
    }
    let end = if random.random_range(0..8) == 0 {
        "\r\n"
    } else {
        "\n"
    };
    lines.join(end) + end
}

fn mutate(lines: &mut Vec<String>, separator: char, words: &[String], random: &mut Random) {
    let n = lines.len();
    // The first line defines the columns of the others.
    let line = if random.random_range(0..3) == 0 {
        0
    } else {
        random.random_range(0..n)
    };
    let other = random.random_range(0..n);
    match random.random_range(0..12) {
        0 => drop(lines.remove(line)),
        1 => lines.swap(line, other),
        2 => lines.insert(other, lines[line].clone()),
        3 => {
            let copies = random.random_range(2..MAX_COPIES);
            let copies = vec![lines[line].clone(); copies];
            lines.extend(copies);
        }
        4 => lines.insert(line, value(words, random)),
        5 => change_column(lines, separator, random),
        _ => lines[line] = with_other_cell(&lines[line], separator, words, random),
    }
}

fn with_other_cell(line: &str, separator: char, words: &[String], random: &mut Random) -> String {
    let mut cells: Vec<String> = line.split(separator).map(Into::into).collect();
    let cell = random.random_range(0..cells.len());
    match random.random_range(0..8) {
        0 => drop(cells.remove(cell)),
        1 => cells.push(value(words, random)),
        2 => cells[cell] = format!("\"{}\"", cells[cell]),
        3 => cells[cell].push('"'),
        4 => cells[cell] = any(words, random).cloned().unwrap_or_default(),
        5 => cells[cell] = value(words, random),
        _ => cells[cell] = any(&NUMBERS, random).map_or_else(String::new, |&x| x.into()),
    }
    cells.join(&separator.to_string())
}

/// Drops or repeats a column.
fn change_column(lines: &mut [String], separator: char, random: &mut Random) {
    let width = lines[0].split(separator).count();
    let (column, is_dropped) = (
        random.random_range(0..width),
        random.random_range(0..2) == 0,
    );
    for line in lines {
        let mut cells: Vec<&str> = line.split(separator).collect();
        match cells.get(column) {
            Some(_) if is_dropped => {
                cells.remove(column);
            }
            Some(&cell) => cells.push(cell),
            None => {}
        }
        *line = cells.join(&separator.to_string());
    }
}
