//! `radgrad eval`: answers to a stream of cases, in their order, in bounded memory.
//!
//! Lines are taken as many at a time as the input has ready, up to the size of one buffer, answered on all cores, and written
//! before more are read: memory is bounded by the buffer and the longest line, and a program that sends one case and waits gets
//! its answer. Each line may take so many operations, so that none holds up the rest for longer: whether it has an answer does not
//! depend on what else the machine does.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};

use radgrad_scene::Error;
use radgrad_scene::case::{Id, Line, Refusal};
use rayon::prelude::*;

/// Bytes read at a time: some 400 cases of a triangle, enough work for every core between two reads.
const BUFFER: usize = 1 << 18;

/// Bytes that a line may have: a longer one is refused, and passed over.
const LONGEST_LINE: usize = 16 << 20;

/// Bytes without an end of the line after which the input is taken for none.
const ENDLESS: u64 = 1 << 30;

/// A line as it was read.
enum Input {
    Text(Vec<u8>),
    /// The beginning of a line that is too long.
    TooLong(Vec<u8>),
}

/// Counts of lines answered and refused.
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

/// The reply to one line.
struct Reply {
    text: Vec<u8>,
    refused: bool,
}

/// The limits of lines, and the requests to all of them beside their own.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Asked {
    /// Operations a line.
    pub(crate) effort: u64,
    /// Second derivatives.
    pub(crate) hessian: bool,
}

/// Answers every line of `input` on `output`. A reader that has seen enough and closes `output` ends the work, without an error.
pub(crate) fn answer_all(input: impl Read, mut output: impl Write, asked: Asked) -> Result<Tally, Failure> {
    let mut reader = BufReader::with_capacity(BUFFER, input);
    let (mut tally, mut first) = (Tally::default(), 1);
    loop {
        let lines = ready_lines(&mut reader).map_err(Failure::Read)?;
        if lines.is_empty() {
            return Ok(tally);
        }
        let count = lines.len();
        let numbered = lines.par_iter().enumerate().map(|(index, line)| safe_reply(first + index, line, asked));
        let replies: Vec<Option<Reply>> = numbered.collect();
        first += count;
        let mut text = Vec::new();
        for reply in replies.into_iter().flatten() {
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
fn ready_lines(reader: &mut BufReader<impl Read>) -> io::Result<Vec<Input>> {
    let mut lines = Vec::new();
    while lines.is_empty() || reader.buffer().contains(&b'\n') {
        match next_line(reader)? {
            Some(line) => lines.push(line),
            None => break,
        }
    }
    Ok(lines)
}

/// The next line, of which no more is kept than a line may have.
fn next_line(reader: &mut impl BufRead) -> io::Result<Option<Input>> {
    let mut line = Vec::new();
    let length = reader.by_ref().take(LONGEST_LINE as u64 + 1).read_until(b'\n', &mut line)?;
    if length <= LONGEST_LINE {
        return Ok((length > 0).then_some(Input::Text(line)));
    }
    if !line.ends_with(b"\n") && reader.by_ref().take(ENDLESS).skip_until(b'\n')? as u64 == ENDLESS {
        return Err(io::Error::new(io::ErrorKind::InvalidData, "a line does not end within 1 GiB"));
    }
    line.truncate(LONGEST_LINE);
    Ok(Some(Input::TooLong(line)))
}

/// The reply to line `number`; none to a blank one. A fault of the program costs its own line only.
fn safe_reply(number: usize, line: &Input, asked: Asked) -> Option<Reply> {
    let answered = catch_unwind(AssertUnwindSafe(|| reply(number, line, asked)));
    answered.unwrap_or_else(|_| refusal(number, line, Error::Fault))
}

fn reply(number: usize, line: &Input, asked: Asked) -> Option<Reply> {
    let Input::Text(text) = line else { return refusal(number, line, Error::TooLong { bytes: LONGEST_LINE }) };
    let answer = Line::read(number, text)?.and_then(|mut line| {
        line.wanted.hessian |= asked.hessian;
        line.answer_within(asked.effort)
    });
    Some(answer.map_or_else(|refusal| Reply::new(&refusal, true), |answer| Reply::new(&answer, false)))
}

fn refusal(number: usize, line: &Input, error: Error) -> Option<Reply> {
    let (Input::Text(text) | Input::TooLong(text)) = line;
    Some(Reply::new(&Refusal { id: Id::find(text), line: number, error }, true))
}

impl Reply {
    /// Records have only keys that are text, and numbers that JSON has: they can be written.
    fn new(record: &impl serde::Serialize, refused: bool) -> Self {
        let mut text = serde_json::to_vec(record).unwrap_or_default();
        text.push(b'\n');
        Self { text, refused }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ASKED: Asked = Asked { effort: 1_000_000_000, hessian: false };

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
            let lines = ready_lines(&mut reader).unwrap();
            assert!(matches!(&lines[..], [Input::Text(line)] if line == expected));
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
    fn a_line_that_is_too_long_costs_itself_only() {
        let long = [b"{\"id\":7,".as_slice(), &b" ".repeat(LONGEST_LINE), b"\nnonsense\n"].concat();
        let mut output = Vec::new();
        let tally = answer_all(long.as_slice(), &mut output, ASKED).unwrap();
        assert_eq!(tally, Tally { lines: 2, refused: 2 });
        let lines: Vec<serde_json::Value> =
            output.split(|&byte| byte == b'\n').filter(|l| !l.is_empty()).map(|l| serde_json::from_slice(l).unwrap()).collect();
        assert_eq!((&lines[0]["id"], &lines[0]["error"]), (&7.into(), &"a line has at most 16 MiB, this one more".into()));
        assert_eq!(lines[1]["line"], 2);
        let endless = answer_all(io::repeat(b'x'), io::sink(), ASKED);
        assert!(matches!(endless, Err(Failure::Read(_))));
    }

    #[test]
    fn a_line_that_takes_too_many_operations_is_refused_by_their_count_and_costs_itself_only() {
        let lamp = |vertices: &str| {
            format!(
                r#"{{"id":1,"receiver":{{"position":[0,0,0],"normal":[0,0,1]}},"emitter":{{"vertices":[{vertices}],"emission":{{"constant":1}}}}}}"#
            )
        };
        let many: Vec<String> = (0..50_000_i64).map(|k| format!("[{k},{},1]", k * k)).collect();
        let text = [lamp(&many.join(",")), lamp("[0,0,1],[0,1,1],[1,0,1]")].join("\n");
        let mut output = Vec::new();
        let tally = answer_all(text.as_bytes(), &mut output, ASKED).unwrap();
        assert_eq!(tally, Tally { lines: 2, refused: 1 });
        let said = String::from_utf8(output).unwrap();
        assert!(
            said.contains("it takes at least 5.00e9 operations, and a line may take 1.00e9") && said.contains("radiosity"),
            "{said}"
        );
    }

    #[test]
    fn a_closed_output_ends_the_work_and_another_failure_is_reported() {
        let line = [b"x".repeat(99).as_slice(), b"\n"].concat();
        let text = line.repeat(4 * BUFFER / line.len());
        for kind in [io::ErrorKind::BrokenPipe, io::ErrorKind::StorageFull] {
            let result = answer_all(text.as_slice(), Closing { kind, written: Vec::new() }, ASKED);
            match kind {
                io::ErrorKind::BrokenPipe => assert!(result.unwrap().lines < 3 * BUFFER / line.len()),
                _ => assert!(matches!(result, Err(Failure::Write(_)))),
            }
        }
    }
}
