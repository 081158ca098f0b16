//! Parses values by their syntax alone, without the type that precedes them.

use super::super::value::{Text, Value};
use super::{MAX_DEPTH, Parser};
use crate::error::Result;

impl Parser<'_, '_> {
    /// Parses a value that is nested in `depth` others.
    pub(super) fn value(&mut self, depth: usize) -> Result<Value> {
        if depth >= MAX_DEPTH {
            let found = format!("more than {MAX_DEPTH} values in each other");
            return Err(self.cursor.invalid(&found, "fewer"));
        }
        Ok(match self.cursor.peek() {
            Some(b'"' | b'\'') => Value::Text(self.cursor.string()?.as_str().into()),
            Some(b'@') => Value::Text(self.cursor.asset()?.as_str().into()),
            Some(b'<') => Value::Text(self.cursor.path()?.into()),
            Some(b'{') => {
                self.cursor.skip_block()?;
                Value::Other
            }
            Some(b'(') => {
                let mut numbers = Vec::new();
                self.tuple(&mut numbers, depth)?;
                Value::Tuple(numbers)
            }
            Some(b'[') => self.array(depth)?,
            Some(b'0'..=b'9' | b'-' | b'+' | b'.') => Value::Number(self.cursor.number()?),
            _ => match self.cursor.word("a value")? {
                "None" | "AnimationBlock" => Value::Blocked,
                "true" | "True" | "yes" => Value::Number(1.0),
                "false" | "False" | "no" => Value::Number(0.0),
                "inf" => Value::Number(f64::INFINITY),
                "nan" => Value::Number(f64::NAN),
                word => Value::Text(word.into()),
            },
        })
    }

    /// Appends the numbers of a tuple, including those of tuples in it.
    fn tuple(&mut self, numbers: &mut Vec<f64>, depth: usize) -> Result<()> {
        self.cursor.expect(b'(')?;
        while !self.cursor.eat(b')') {
            match self.cursor.peek() {
                Some(b'(') if depth < MAX_DEPTH => self.tuple(numbers, depth + 1)?,
                _ => numbers.push(self.cursor.number()?),
            }
            self.cursor.eat(b',');
        }
        Ok(())
    }

    fn array(&mut self, depth: usize) -> Result<Value> {
        self.cursor.expect(b'[')?;
        let (mut width, mut numbers, mut texts) = (1, Vec::new(), Vec::<Text>::new());
        let mut has_others = false;
        while !self.cursor.eat(b']') {
            match self.cursor.peek() {
                Some(b'(') => {
                    let before = numbers.len();
                    self.tuple(&mut numbers, depth)?;
                    let found = numbers.len() - before;
                    if before == 0 {
                        width = found.max(1);
                    }
                    if found != width {
                        let expected = format!("{width}, as before it");
                        return Err(self.cursor.invalid(&format!("a tuple of {found} numbers"), &expected));
                    }
                }
                Some(b'0'..=b'9' | b'-' | b'+' | b'.') => numbers.push(self.cursor.number()?),
                _ => match self.value(depth + 1)? {
                    Value::Number(number) => numbers.push(number),
                    Value::Text(text) => texts.push(text),
                    _ => has_others = true,
                },
            }
            self.cursor.eat(b',');
        }
        Ok(match (numbers.is_empty(), texts.is_empty()) {
            (false, false) => Value::Other,
            _ if has_others => Value::Other,
            (_, true) if numbers.len() % width == 0 => Value::Array { width, numbers },
            (_, true) => Value::Other,
            (true, false) => Value::Texts(texts),
        })
    }
}
