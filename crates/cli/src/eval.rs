//! `radgrad eval`: answers to a stream of cases, in their order, in bounded memory.
//!
//! Lines are taken as many at a time as the input has ready, up to the size of one buffer, answered on all cores, and written
//! before more are read: memory is bounded by the buffer and the longest line, and a program that sends one case and waits gets
//! its answer.

use std::io::{self, BufRead, BufReader, Read, Write};

use radgrad_scene::case::Line;
use rayon::prelude::*;

/// Bytes read at a time: some 400 cases of a triangle, enough work for every core between two reads.
const BUFFER: usize = 1 << 18;

/// What became of the lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Tally {
    /// Lines that are not blank.
    pub(crate) lines: usize,
    /// Those of them without an answer.
    pub(crate) refused: usize,
}

/// Why the rest of the cases was not answered.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// The input ended in an error.
    #[error("cannot read: {0}")]
    Read(#[source] io::Error),
    /// The answers cannot be written.
    #[error("cannot write the answers: {0}")]
    Write(#[source] io::Error),
}

/// What is written for one line.
struct Reply {
    text: Vec<u8>,
    refused: bool,
}

/// Answers every line of `input` on `output`. A reader that has seen enough and closes `output` ends the work, without an error.
pub(crate) fn answer_all(input: impl Read, mut output: impl Write) -> Result<Tally, Failure> {
    let mut reader = BufReader::with_capacity(BUFFER, input);
    let (mut tally, mut first) = (Tally::default(), 1);
    loop {
        let lines = ready_lines(&mut reader).map_err(Failure::Read)?;
        if lines.is_empty() {
            return Ok(tally);
        }
        let replies: Vec<Option<Reply>> = lines
            .par_iter()
            .enumerate()
            .map(|(index, text)| reply(first + index, text))
            .collect::<io::Result<_>>()
            .map_err(Failure::Write)?;
        first += lines.len();
        let mut text = Vec::new();
        for reply in replies.iter().flatten() {
            tally.lines += 1;
            tally.refused += usize::from(reply.refused);
            text.extend_from_slice(&reply.text);
        }
        match output.write_all(&text).and_then(|()| output.flush()) {
            Ok(()) => {}
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => return Ok(tally),
            Err(error) => return Err(Failure::Write(error)),
        }
    }
}

/// The next line, and those after it that stand complete in the buffer; none at the end of the input.
fn ready_lines(reader: &mut BufReader<impl Read>) -> io::Result<Vec<Vec<u8>>> {
    let mut lines = Vec::new();
    while lines.is_empty() || reader.buffer().contains(&b'\n') {
        let mut line = Vec::new();
        if reader.read_until(b'\n', &mut line)? == 0 {
            break;
        }
        lines.push(line);
    }
    Ok(lines)
}

/// What is written for line `number`; nothing for a blank one.
fn reply(number: usize, text: &[u8]) -> io::Result<Option<Reply>> {
    let Some(line) = Line::read(number, text) else { return Ok(None) };
    let (mut text, refused) = match line.and_then(Line::answer) {
        Ok(answer) => (serde_json::to_vec(&answer)?, false),
        Err(refusal) => (serde_json::to_vec(&refusal)?, true),
    };
    text.push(b'\n');
    Ok(Some(Reply { text, refused }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives one byte a call, like a program that sends slowly.
    struct Trickle<'a> {
        left: &'a [u8],
    }

    impl Read for Trickle<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let (Some((first, rest)), Some(place)) = (self.left.split_first(), buffer.first_mut()) else { return Ok(0) };
            (*place, self.left) = (*first, rest);
            Ok(1)
        }
    }

    /// Fails with `kind` from the second write on.
    struct Closing {
        kind: io::ErrorKind,
        written: Vec<u8>,
    }

    impl Write for Closing {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if !self.written.is_empty() {
                return Err(self.kind.into());
            }
            self.written.extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_line_is_answered_before_the_next_one_is_read() {
        let mut reader = BufReader::with_capacity(BUFFER, Trickle { left: b"first\nsecond\nlast" });
        for expected in [&b"first\n"[..], b"second\n", b"last"] {
            assert_eq!(ready_lines(&mut reader).unwrap(), [expected]);
        }
        assert!(ready_lines(&mut reader).unwrap().is_empty());
    }

    #[test]
    fn lines_that_are_ready_go_together_and_no_more_than_a_buffer_of_them() {
        let text = b"0123456789\n".repeat(100);
        let mut reader = BufReader::with_capacity(64, text.as_slice());
        let (mut lines, mut batches) = (0, 0);
        loop {
            let ready = ready_lines(&mut reader).unwrap();
            if ready.is_empty() {
                break;
            }
            assert!(ready.len() <= 7, "{}", ready.len());
            (lines, batches) = (lines + ready.len(), batches + 1);
        }
        assert_eq!(lines, 100);
        assert!(batches <= 25, "{batches}");
    }

    #[test]
    fn a_closed_output_ends_the_work_and_another_failure_is_reported() {
        let line = [b"x".repeat(99).as_slice(), b"\n"].concat();
        let text = line.repeat(4 * BUFFER / line.len());
        for kind in [io::ErrorKind::BrokenPipe, io::ErrorKind::StorageFull] {
            let result = answer_all(text.as_slice(), Closing { kind, written: Vec::new() });
            match kind {
                io::ErrorKind::BrokenPipe => assert!(result.unwrap().lines < 3 * BUFFER / line.len()),
                _ => assert!(matches!(result, Err(Failure::Write(_)))),
            }
        }
    }
}
