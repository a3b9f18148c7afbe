//! Tables over time, as a force or activity model supplies them: CSV, times in the first column, one muscle in each other.

use crate::error::{MuscleError, TableError, one_line};
use crate::rig::muscle::{Curve, MuscleSpec, Source};
use crate::rig::nearest::nearest;
use csv::{ReaderBuilder, StringRecord, Trim};
use std::collections::HashSet;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// Largest file that is read, bytes.
const BYTES: u64 = 64 << 20;
/// Most numbers that one table holds, and that all muscles' curves together take from tables.
const CELLS: usize = 10_000_000;
/// Columns among which the nearest names are looked for.
const COMPARED: usize = 1000;

/// A table over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    file: String,
    times: Vec<f32>,
    names: Vec<String>,
    columns: Vec<Vec<f32>>,
}

impl Table {
    /// Reads the CSV file at `path`.
    ///
    /// # Errors
    /// It cannot be read, is over 64 MiB or 10 million numbers, or is no table: line and column are named.
    pub fn read(path: &Path) -> Result<Table, TableError> {
        let file = one_line(&path.display().to_string());
        let fail = |e: std::io::Error| TableError::Unreadable { file: file.clone(), reason: one_line(&e.to_string()) };
        // Reading a pipe or a device might never end.
        if !std::fs::metadata(path).map_err(fail)?.is_file() {
            return Err(fail(std::io::Error::other("it is not a plain file")));
        }
        let mut bytes = Vec::new();
        std::fs::File::open(path).and_then(|f| f.take(BYTES + 1).read_to_end(&mut bytes)).map_err(fail)?;
        if bytes.len() as u64 > BYTES {
            return Err(TableError::TooLarge { file, unit: "bytes", most: BYTES });
        }
        match String::from_utf8(bytes) {
            Ok(text) => Table::parse(&text, path),
            Err(error) => {
                let before = &error.as_bytes()[..error.utf8_error().valid_up_to()];
                let line = 1 + before.iter().filter(|b| **b == b'\n').count() as u64;
                Err(cell(&file, line, 1, "the text is not UTF-8".into(), "save the table as UTF-8"))
            }
        }
    }

    /// Reads a text; `path` is for messages.
    ///
    /// The first row names the columns, the first of which is `time`: seconds after the clip's start, ascending.
    ///
    /// # Errors
    /// As [`Table::read`], less the file system's.
    pub fn parse(text: &str, path: &Path) -> Result<Table, TableError> {
        let file = one_line(&path.display().to_string());
        let mut reader =
            ReaderBuilder::new().has_headers(false).flexible(true).trim(Trim::All).from_reader(text.as_bytes());
        let mut row = StringRecord::new();
        let mut next = |row: &mut StringRecord| {
            let more = reader.read_record(row);
            // The reader counts from the end of the row before, and so from before any empty lines.
            let start = row.position().map_or((0, 1), |p| (p.byte() as usize, p.line()));
            let ends = text.as_bytes().iter().skip(start.0).take_while(|b| matches!(b, b'\r' | b'\n'));
            let line = start.1 + ends.filter(|b| **b == b'\n').count() as u64;
            more.map(|more| more.then_some(line))
                .map_err(|e| cell(&file, line, 1, one_line(&e.to_string()), "save the table as CSV again"))
        };
        let Some(line) = next(&mut row)? else {
            return Err(cell(&file, 1, 1, "the table is empty".into(), "name the columns in the first row"));
        };
        let names = headings(&file, line, &row)?;
        let mut table = Table { file: file.clone(), times: Vec::new(), columns: vec![Vec::new(); names.len()], names };
        let mut last = f64::NEG_INFINITY;
        while let Some(line) = next(&mut row)? {
            table.add(line, &row, &mut last)?;
        }
        if table.times.is_empty() {
            return Err(cell(&table.file, line + 1, 1, "no row follows the names".into(), "add a row for each time"));
        }
        Ok(table)
    }

    fn add(&mut self, line: u64, row: &StringRecord, last: &mut f64) -> Result<(), TableError> {
        let width = self.names.len() + 1;
        if row.len() != width {
            let what = format!("the row has {} cells, and the first row {width}", row.len());
            return Err(cell(&self.file, line, row.len().min(width), what, "give every row as many cells as names"));
        }
        if (self.times.len() + 1) * width > CELLS {
            return Err(TableError::TooLarge { file: self.file.clone(), unit: "numbers", most: CELLS as u64 });
        }
        let number = |column: usize| -> Result<f64, TableError> {
            let text = row.get(column).unwrap_or_default();
            let value = text.parse::<f64>().ok().filter(|v| (*v as f32).is_finite());
            value.ok_or_else(|| {
                let what = format!("`{}` is not a finite number", one_line(text));
                cell(&self.file, line, column + 1, what, "write a plain decimal such as 0.25")
            })
        };
        let time = number(0)?;
        if time <= *last {
            let what = format!("the time {time} s does not come after {last} s, the row before");
            return Err(cell(&self.file, line, 1, what, "sort the rows by time, one row each"));
        }
        let values = (1..width).map(number).collect::<Result<Vec<f64>, _>>()?;
        self.columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value as f32));
        self.times.push(time as f32);
        *last = time;
        Ok(())
    }

    /// Names of the columns but `time`'s.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Seconds after the clip's start, one per row, ascending.
    pub fn times(&self) -> &[f32] {
        &self.times
    }

    /// The column of this name as a curve, straight from row to row.
    pub fn curve(&self, name: &str) -> Option<Curve> {
        let column = self.names.iter().position(|n| n == name)?;
        Some(Curve { times: self.times.clone(), values: self.columns[column].clone(), ..Curve::default() })
    }

    /// Up to three columns whose names are most like this one.
    fn nearest(&self, name: &str) -> String {
        let names = self.names.iter().take(COMPARED).map(String::as_str);
        let names: Vec<String> = nearest(name, names, 3).into_iter().map(one_line).collect();
        names.join(", ")
    }
}

fn headings(file: &str, line: u64, row: &StringRecord) -> Result<Vec<String>, TableError> {
    let time = row.get(0).unwrap_or_default();
    if time != "time" {
        let what = format!("the first column is `{}` and must be `time`", one_line(time));
        return Err(cell(file, line, 1, what, "name it so, and separate columns by commas"));
    }
    let mut known = HashSet::new();
    for (column, name) in row.iter().enumerate() {
        let what = match known.insert(name) {
            _ if name.is_empty() => "it has no name".into(),
            false => format!("the name `{}` stands twice", one_line(name)),
            true => continue,
        };
        return Err(cell(file, line, column + 1, what, "give every column a name of its own"));
    }
    if row.len() == 1 {
        return Err(cell(file, line, 1, "no column follows the time's".into(), "add a column for each muscle"));
    }
    Ok(row.iter().skip(1).map(str::to_owned).collect())
}

fn cell(file: &str, line: u64, column: usize, what: String, remedy: &'static str) -> TableError {
    TableError::Cell { file: file.into(), line, column, what, remedy }
}

/// Fills the curves of all drivers that read a table. Each file is read once; `folder` is the muscle file's.
///
/// # Errors
/// A table that cannot be read, see [`Table::read`], that is outside `folder`, or that lacks a column (nearest names are
/// listed); curves of 10 million numbers in all. The first muscle that asks for it is named.
pub fn load_tables(specs: &mut [MuscleSpec], folder: &Path) -> Result<(), MuscleError> {
    let mut files: Vec<(PathBuf, usize, usize)> = Vec::new();
    let mut known = HashSet::new();
    for (muscle, spec) in specs.iter().enumerate() {
        for (number, driver) in spec.drive.drivers.iter().enumerate() {
            if let Source::Table { file, .. } = &driver.source
                && known.insert(file.clone())
            {
                files.push((file.clone(), muscle, number));
            }
        }
    }
    let mut left = CELLS;
    for (wanted, muscle, driver) in files {
        let failed = |muscle: &str, driver, source| MuscleError::Table { muscle: muscle.into(), driver, source };
        let table = inside(&wanted).and_then(|path| Table::read(&folder.join(path)));
        let table = table.map_err(|source| failed(&specs[muscle].name, driver, source))?;
        for spec in &mut *specs {
            for (number, driver) in spec.drive.drivers.iter_mut().enumerate() {
                let Source::Table { file, column, curve } = &mut driver.source else { continue };
                if *file == wanted {
                    *curve = take(&table, column, &mut left).map_err(|source| failed(&spec.name, number, source))?;
                }
            }
        }
    }
    Ok(())
}

/// A column as a curve, less its numbers from what is `left` for all muscles together.
fn take(table: &Table, column: &str, left: &mut usize) -> Result<Curve, TableError> {
    let file = || table.file.clone();
    let rest = left.checked_sub(table.times.len());
    *left = rest.ok_or_else(|| TableError::TooLarge { file: file(), unit: "numbers in use", most: CELLS as u64 })?;
    table.curve(column).ok_or_else(|| TableError::Column {
        file: file(),
        column: one_line(column),
        nearest: table.nearest(column),
    })
}

/// The path, where it stays in the muscle file's folder: a file from elsewhere must not reach into ours.
fn inside(path: &Path) -> Result<&Path, TableError> {
    let mut depth = 0i64;
    for component in path.components() {
        depth += match component {
            Component::Normal(_) => 1,
            Component::CurDir => 0,
            Component::ParentDir => -1,
            Component::RootDir | Component::Prefix(_) => i64::from(i32::MIN),
        };
        if depth < 0 {
            let file = one_line(&path.display().to_string());
            return Err(TableError::Unreadable { file, reason: "it is outside the muscle file's folder".into() });
        }
    }
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::muscle::{Attachment, Combine, Driver, MuscleSize};
    use glam::Vec3;
    use proptest::prelude::*;

    fn parsed(text: &str) -> Result<Table, TableError> {
        Table::parse(text, Path::new("forces.csv"))
    }

    fn refused(text: &str) -> String {
        let line = parsed(text).map(drop).expect_err("must be refused").to_string();
        assert!(line.starts_with("forces.csv") && line.contains("; ") && !line.contains('\n'), "{line}");
        line
    }

    #[test]
    fn columns_are_read_as_curves() {
        let plain = parsed("time,biceps_l,triceps_l\n0,0.1,1\n0.5,0.3,0\n").expect("good");
        assert_eq!(
            (plain.names(), plain.times()),
            (&["biceps_l".to_owned(), "triceps_l".to_owned()][..], &[0.0, 0.5][..])
        );
        let curve = plain.curve("biceps_l").expect("there");
        assert_eq!((curve.at(0.25), curve.at(9.0)), (Some(0.2), Some(0.3)));
        assert_ne!(plain.curve("triceps_l"), Some(curve));
        assert_eq!(plain.curve("time"), None);
        // Quotes, a byte-order mark, other line ends, spaces, empty lines and no last line end make no difference.
        let odd = "\u{feff}\"time\" , biceps_l,\"triceps_l\"\r\n\r\n 0 ,1e-1,1\r\n\n5e-1,\"0.3\",0";
        assert_eq!(parsed(odd).expect("good"), plain);
    }

    #[test]
    fn what_is_no_table_is_refused_by_line_and_column() {
        for (text, expected) in [
            ("", "forces.csv:1: column 1: the table is empty"),
            ("t,a\n0,1\n", "forces.csv:1: column 1: the first column is `t` and must be `time`"),
            ("time;a\n0;1\n", "must be `time`; name it so, and separate columns by commas"),
            ("time\n0\n", "forces.csv:1: column 1: no column follows"),
            ("time,a\n", "forces.csv:2: column 1: no row follows the names"),
            ("time,a,a\n0,1,1\n", "forces.csv:1: column 3: the name `a` stands twice"),
            ("time,a,\n0,1,1\n", "forces.csv:1: column 3: it has no name"),
            ("time,a\n0,1\n1\n", "forces.csv:3: column 1: the row has 1 cells, and the first row 2"),
            ("time,a\n0,1\n1,2,3\n", "forces.csv:3: column 2: the row has 3 cells"),
            ("time,a\n0,1\n\n\n1,x y\n", "forces.csv:5: column 2: `x y` is not a finite number"),
            ("time,a\r\n0,1\r\n\r\n1,NaN\r\n", "forces.csv:4: column 2: `NaN` is not a finite number"),
            ("time,a\n0,\n", "forces.csv:2: column 2: `` is not a finite number"),
            ("time,a\ninf,1\n", "forces.csv:2: column 1: `inf` is not"),
            ("time,a\n0,1e39\n", "forces.csv:2: column 2: `1e39` is not a finite number"),
            ("time,a\n1,0\n1,0\n", "forces.csv:3: column 1: the time 1 s does not come after 1 s"),
            ("time,a\n1,0\n0.5,0\n", "forces.csv:3: column 1: the time 0.5 s does not come after 1 s"),
        ] {
            assert!(refused(text).contains(expected), "{text:?}: {}", refused(text));
        }
        // Sorted and whole, the same rows are good.
        assert!(parsed("time,a\n0.5,0\n1,0\n").is_ok());
    }

    #[test]
    fn tables_beyond_all_use_are_refused() {
        let names: String = (0..2000).map(|i| format!(",m{i}")).collect();
        let row = ",0".repeat(2000);
        let table = |rows: usize| {
            let rows: String = (0..rows).map(|i| format!("{i}{row}\n")).collect();
            parsed(&format!("time{names}\n{rows}"))
        };
        assert!(table(4).is_ok());
        assert_eq!(
            table(4998).map(drop).expect_err("10 million and more").to_string().split(';').next(),
            Some("forces.csv: the table has more than 10000000 numbers")
        );
    }

    fn muscle(name: &str, tables: &[(&str, &str)]) -> MuscleSpec {
        let end = |y| Attachment { bone: "thigh".into(), offset: Vec3::Y * y, normal: Vec3::X };
        let mut spec = MuscleSpec::new(name, "thigh", end(0.1), end(0.5), MuscleSize::Width(0.03));
        let source = |&(file, column): &(&str, &str)| Source::Table {
            file: file.into(),
            column: column.into(),
            curve: Curve::default(),
        };
        spec.drive.drivers = tables.iter().map(|t| Driver { source: source(t), combine: Combine::Max }).collect();
        spec
    }

    #[test]
    fn muscles_get_their_columns() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("a.csv"), "time,left,right\n0,0.25,1\n").expect("written");
        std::fs::create_dir(folder.path().join("sub")).expect("made");
        std::fs::write(folder.path().join("sub/b.csv"), "time,left\n0,0.75\n").expect("written");
        std::fs::write(folder.path().join("latin.csv"), b"time,a\n0,\xe9\n").expect("written");
        let mut specs =
            [muscle("l", &[("a.csv", "left"), ("sub/../sub/b.csv", "left")]), muscle("r", &[("a.csv", "right")])];
        load_tables(&mut specs, folder.path()).expect("all there");
        let value = |spec: &MuscleSpec, driver: usize| match &spec.drive.drivers[driver].source {
            Source::Table { curve, .. } => curve.at(0.0),
            _ => None,
        };
        assert_eq!(
            (value(&specs[0], 0), value(&specs[0], 1), value(&specs[1], 0)),
            (Some(0.25), Some(0.75), Some(1.0))
        );

        let fails = |file: &str, column: &str| {
            load_tables(&mut [muscle("l", &[(file, column)])], folder.path()).expect_err("must be refused").to_string()
        };
        let missing = fails("a.csv", "lfet");
        assert!(
            missing.starts_with("muscle `l`: ")
                && missing.contains("a.csv: the table has no column `lfet`")
                && missing.contains("nearest names: left, right")
        );
        assert!(fails("no.csv", "left").contains("no.csv: the table cannot be read"));
        assert!(fails("sub", "left").contains("not a plain file"));
        assert!(fails("latin.csv", "a").contains("latin.csv:2: column 1: the text is not UTF-8"));
        for path in ["../a.csv", "/etc/passwd", "sub/../../a.csv"] {
            assert!(fails(path, "left").contains("outside the muscle file's folder"), "{path}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn any_text_is_read_or_refused_in_one_line(text in "(time)?[-time0-9.,;\"\r\n ]{0,60}") {
            match parsed(&text) {
                Ok(table) => {
                    prop_assert!(table.times().windows(2).all(|w| w[0] <= w[1]));
                    prop_assert!(table.names().iter().all(|n| table.curve(n).is_some_and(|c| c.values.len() == c.times.len())));
                }
                Err(error) => prop_assert!(!error.to_string().contains(['\n', '\r']), "{}", error),
            }
        }
    }
}
