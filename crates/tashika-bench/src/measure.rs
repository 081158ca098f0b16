//! Timing of several variants in turns, with medians, and ratios to the first variant.

use rustix::time::{ClockId, clock_gettime};

/// Processor time (s) of this thread. Threads of other libraries, which may spin, are not included.
pub fn cpu_seconds() -> f64 {
    seconds(ClockId::ThreadCPUTime)
}

/// Processor time (s) of all threads of this process.
pub fn cpu_seconds_of_all() -> f64 {
    seconds(ClockId::ProcessCPUTime)
}

fn seconds(clock: ClockId) -> f64 {
    let t = clock_gettime(clock);
    t.tv_sec as f64 + t.tv_nsec as f64 * 1e-9
}

/// Named piece of work to be timed.
pub struct Variant<'a> {
    /// Label in the table of results.
    pub name: String,
    /// Closure that runs the variant once.
    pub work: Box<dyn FnMut() + 'a>,
}

impl<'a> Variant<'a> {
    /// Makes a variant from its label and its work.
    pub fn new(name: impl Into<String>, work: impl FnMut() + 'a) -> Self {
        Self { name: name.into(), work: Box::new(work) }
    }
}

/// Measurements of one variant.
#[derive(Clone, Debug)]
pub struct Timed {
    /// Label of the variant.
    pub name: String,
    /// Median of the processor time (s).
    pub seconds: f64,
    /// Median over the rounds of the first variant's time divided by this one's in the same round.
    pub speed: f64,
    /// Smallest and largest of these ratios.
    pub range: [f64; 2],
}

/// Times variants in turns for `rounds` rounds, after a first round that does not count.
pub fn in_turns(variants: &mut [Variant<'_>], rounds: u32) -> Vec<Timed> {
    assert!(rounds > 0, "something has to be measured");
    let mut times = vec![Vec::with_capacity(rounds as usize); variants.len()];
    for round in 0..=rounds {
        for (variant, times) in variants.iter_mut().zip(&mut times) {
            let begun = cpu_seconds();
            (variant.work)();
            let taken = cpu_seconds() - begun;
            if round > 0 {
                times.push(taken);
            }
        }
    }
    let first = times[0].clone();
    let summary = |(variant, times): (&Variant<'_>, Vec<f64>)| {
        let mut speeds: Vec<f64> = first.iter().zip(&times).map(|(first, own)| first / own).collect();
        let speed = median(&mut speeds);
        let range = [speeds[0], speeds[speeds.len() - 1]];
        Timed { name: variant.name.clone(), seconds: median(&mut times.clone()), speed, range }
    };
    variants.iter().zip(times).map(summary).collect()
}

/// Median of the values, which are sorted.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) }
}
