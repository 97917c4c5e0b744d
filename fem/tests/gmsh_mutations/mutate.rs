//! Mutations of files: bits, bytes, numbers, lines, pieces.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// Random numbers, the same at every run: SplitMix64 (Steele, Lea, Flood 2014).
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Self {
        Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15))
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `count`, which is not zero.
    fn below(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }

    fn range(&mut self, length: usize) -> std::ops::Range<usize> {
        let start = self.below(length + 1);
        start..start + self.below((length - start).min(64) + 1)
    }
}

const NUMBERS: [&str; 26] = [
    "0",
    "-1",
    "1",
    "2",
    "3",
    "4",
    "5",
    "8",
    "9",
    "10",
    "12",
    "15",
    "16",
    "99",
    "255",
    "1e308",
    "-1e-308",
    "nan",
    "inf",
    "0.5",
    "2147483647",
    "-2147483648",
    "4294967296",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551615",
];

const VALUES: [u64; 14] = [
    0,
    1,
    2,
    3,
    9,
    15,
    255,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x7ff0_0000_0000_0000,
    0x7fff_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
    u64::MAX,
];

/// Number of files to mutate: `FORMS_MUTATIONS`; or all where sweeps are asked for, and a tenth of them as a rule.
pub fn count(in_sweeps: u64) -> u64 {
    match std::env::var("FORMS_MUTATIONS") {
        Ok(count) => count.parse().expect("FORMS_MUTATIONS is a number"),
        Err(_) if std::env::var_os("FORMS_SWEEPS").is_some() => in_sweeps,
        Err(_) => in_sweeps / 10,
    }
}

/// Processor time after which a reader counts as one that does not end \[s\]. The files have some hundred lines.
const LONGEST: f64 = 60.0;

/// Number of mutated files that a reader accepts; none may make it panic or think long.
pub fn accepted(corpus: &[Vec<u8>], mutations: u64, reads: impl Fn(&[u8]) -> bool + Sync) -> u64 {
    let threads = std::thread::available_parallelism().map_or(1, |count| count.get()) as u64;
    let start = std::time::Instant::now();
    let run = |thread: u64| {
        let mut accepted = 0;
        for number in (thread..mutations).step_by(threads as usize) {
            let mutated = mutate(corpus, &mut Random::new(number));
            let begin = processor_time();
            let read = catch_unwind(AssertUnwindSafe(|| reads(&mutated)));
            let taken = processor_time() - begin;
            assert!(taken < LONGEST, "mutation {number} takes {taken} s");
            accepted += u64::from(read.unwrap_or_else(|_| panic!("mutation {number} panics")));
        }
        accepted
    };
    let accepted: u64 = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads)
            .map(|thread| {
                scope.spawn({
                    let run = &run;
                    move || run(thread)
                })
            })
            .collect();
        workers.into_iter().map(|worker| worker.join().expect("no mutation panics")).sum()
    });
    println!(
        "{mutations} mutated files: {accepted} read, {} refused, in {:.1} s",
        mutations - accepted,
        start.elapsed().as_secs_f64()
    );
    accepted
}

/// Processor time of this thread \[s\], where the system tells it; otherwise the time of day, which is longer.
fn processor_time() -> f64 {
    let ticks = std::fs::read_to_string("/proc/thread-self/stat").ok().and_then(|line| {
        // After the name, in brackets; user and system time, in hundredths of a second.
        let rest = line.rsplit(')').next()?;
        let mut fields = rest.split_whitespace().skip(11).map(str::parse::<f64>);
        Some(fields.next()?.ok()? + fields.next()?.ok()?)
    });
    ticks.map_or_else(
        || {
            let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
            since.map_or(0.0, |time| time.as_secs_f64())
        },
        |ticks| 0.01 * ticks,
    )
}

/// A file of the corpus with one to three changes.
fn mutate(corpus: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut file = corpus[random.below(corpus.len())].clone();
    for _ in 0..1 + random.below(3) {
        if file.is_empty() {
            return file;
        }
        change(&mut file, corpus, random);
    }
    file
}

fn change(file: &mut Vec<u8>, corpus: &[Vec<u8>], random: &mut Random) {
    let length = file.len();
    match random.below(12) {
        0 | 1 => file[random.below(length)] ^= 1 << random.below(8),
        2 => file[random.below(length)] = random.below(256) as u8,
        3 => file.truncate(random.below(length)),
        4 | 5 => replace_number(file, random),
        6 => overwrite_number(file, random),
        7 => with_lines(file, |lines| {
            let (a, b) = (random.below(lines.len()), random.below(lines.len()));
            lines.swap(a, b);
        }),
        8 => with_lines(file, |lines| {
            let line = lines[random.below(lines.len())].clone();
            lines.insert(random.below(lines.len() + 1), line);
        }),
        9 => with_lines(file, |lines| {
            lines.remove(random.below(lines.len()));
        }),
        10 => {
            let piece = file[random.range(length)].to_vec();
            let place = random.below(length + 1);
            file.splice(place..place, piece);
        }
        _ => {
            let other = &corpus[random.below(corpus.len())];
            let piece = other[random.range(other.len())].to_vec();
            let replaced = random.range(length);
            file.splice(replaced, piece);
        }
    }
}

// A word of digits becomes another number; in binary files that hits names, counts and the header.
fn replace_number(file: &mut Vec<u8>, random: &mut Random) {
    let digit = |byte: &u8| byte.is_ascii_digit() || b"+-.eE".contains(byte);
    let from = random.below(file.len());
    let Some(start) = file[from..].iter().position(u8::is_ascii_digit).map(|offset| from + offset) else {
        return;
    };
    let end = file[start..].iter().position(|byte| !digit(byte)).map_or(file.len(), |offset| start + offset);
    let number = NUMBERS[random.below(NUMBERS.len())].bytes();
    file.splice(start..end, number);
}

fn overwrite_number(file: &mut [u8], random: &mut Random) {
    let value = VALUES[random.below(VALUES.len())];
    let bytes = if random.below(2) == 0 { value.to_le_bytes() } else { value.to_be_bytes() };
    let start = random.below(file.len());
    let length = [4, 8][random.below(2)];
    for (place, byte) in file[start..].iter_mut().zip(&bytes[8 - length..]) {
        *place = *byte;
    }
}

fn with_lines(file: &mut Vec<u8>, change: impl FnOnce(&mut Vec<Vec<u8>>)) {
    let mut lines: Vec<Vec<u8>> = file.split_inclusive(|&byte| byte == b'\n').map(<[u8]>::to_vec).collect();
    change(&mut lines);
    *file = lines.concat();
}
