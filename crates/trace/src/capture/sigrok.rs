//! sigrok's session files: an archive with `metadata` and the samples in `logic-1-1`, `logic-1-2` and so on.

use std::io::{self, Read, Seek};
use std::ops::ControlFlow;

use zip::ZipArchive;
use zip::result::ZipError;

use super::decimal::{SampleRate, hertz};
use super::{CHANNELS_MAX, CaptureChange, CaptureEnd, CapturePlace, CaptureProblem, Told, Wrong, in_file};

/// More of the metadata is not read.
const METADATA_MAX: u64 = 1 << 20;

/// Bytes read at a time: many windows of the packing, which copies its own after each reading.
const PIECE: usize = 256 * 1024;

/// Bytes that are compared at once.
const WIDE: usize = 16;

/// So many times, before whole blocks are.
const NEAR: usize = 4;

/// Bytes of a block.
const FAR: usize = 512;

/// What the metadata says.
pub(super) struct Head {
    rate: SampleRate,
    /// Bytes of a sample.
    unit: usize,
    /// Of each channel its bit.
    bits: Vec<usize>,
    /// What the names of the samples begin with.
    capture: String,
}

impl Head {
    pub(super) const fn hertz(&self) -> u64 {
        self.rate.hertz()
    }

    pub(super) const fn sample_ns(&self) -> u64 {
        self.rate.period_ns()
    }
}

fn in_part(part: &str, problem: impl std::fmt::Display) -> Wrong {
    (CapturePlace::Part(part.to_owned()), CaptureProblem::refused(problem))
}

fn open<R: Read + Seek>(source: R) -> Result<ZipArchive<R>, Wrong> {
    let refused = |cause| {
        let problem = match cause {
            ZipError::InvalidArchive(_) => {
                "no whole session of sigrok: the end of the archive is missing, as of a \
                                            file that was cut"
                    .to_owned()
            }
            cause => format!("no session of sigrok: {cause}"),
        };
        (CapturePlace::File, CaptureProblem::Refused(problem))
    };
    ZipArchive::new(source).map_err(refused)
}

/// Reads the metadata.
pub(super) fn head<R: Read + Seek>(source: R) -> Result<(Head, Vec<String>), Wrong> {
    let mut archive = open(source)?;
    let mut text = String::new();
    let part = archive.by_name("metadata").map_err(|cause| in_part("metadata", cause))?;
    part.take(METADATA_MAX).read_to_string(&mut text).map_err(|cause| in_part("metadata", cause))?;
    parse(&text)
}

/// The keys of `[device 1]`.
#[expect(clippy::disallowed_methods, reason = "sigrok's metadata has counts in decimal digits")]
fn parse(text: &str) -> Result<(Head, Vec<String>), Wrong> {
    let wrong = |problem: String| in_part("metadata", problem);
    let device = text.split_once("[device 1]").map(|(_, rest)| rest);
    let device = device.ok_or_else(|| wrong("there is no [device 1]".to_owned()))?;
    let lines = device.lines().map(str::trim).take_while(|line| !line.starts_with('['));
    let (mut samplerate, mut unit, mut capture, mut probes) = (None, None, None, Vec::new());
    for (key, value) in lines.filter_map(|line| line.split_once('=')) {
        match key.trim() {
            "samplerate" => {
                let rate = hertz(value).ok_or_else(|| wrong(format!("samplerate {value:?} is no rate")))?;
                samplerate = Some(rate);
            }
            "unitsize" => {
                let bytes = value.trim().parse().ok().filter(|bytes| (1..=CHANNELS_MAX / 8).contains(bytes));
                unit = Some(bytes.ok_or_else(|| wrong(format!("unitsize {value:?}: 1 to 512 bytes")))?);
            }
            "capturefile" => capture = Some(value.trim().to_owned()),
            key => {
                let number = key.strip_prefix("probe").and_then(|number| number.parse::<usize>().ok());
                if let Some(number) = number.filter(|number| (1..=CHANNELS_MAX).contains(number)) {
                    probes.push((number - 1, value.trim().to_owned()));
                }
            }
        }
    }
    let unit = unit.ok_or_else(|| wrong("there is no unitsize".to_owned()))?;
    if let Some((bit, name)) = probes.iter().find(|(bit, _)| *bit >= unit * 8) {
        return Err(wrong(format!("probe{} {name:?} is beyond a sample of {unit} bytes", bit + 1)));
    }
    let samplerate = samplerate
        .ok_or_else(|| wrong("there is no samplerate, so no time in the file means anything".to_owned()))?;
    let capture = capture.ok_or_else(|| wrong("there is no capturefile".to_owned()))?;
    let (bits, names) = probes.into_iter().unzip();
    Ok((Head { rate: SampleRate::new(samplerate), unit, bits, capture }, names))
}

/// The parts with samples, in order.
fn parts<R: Read + Seek>(archive: &ZipArchive<R>, capture: &str) -> Result<Vec<String>, Wrong> {
    if archive.index_for_name(capture).is_some() {
        return Ok(vec![capture.to_owned()]);
    }
    let numbered = (1..).map(|number| format!("{capture}-{number}"));
    let parts: Vec<_> = numbered.take_while(|part| archive.index_for_name(part).is_some()).collect();
    let of_capture = |name: &str| name.strip_prefix(capture).is_some_and(|rest| rest.starts_with('-'));
    let there = archive.file_names().filter_map(Result::ok).filter(|name| of_capture(name)).count();
    if parts.is_empty() {
        return Err(in_part(capture, "there are no samples"));
    }
    if there > parts.len() {
        return Err(in_part(
            &format!("{capture}-{}", parts.len() + 1),
            "this part of the samples is missing",
        ));
    }
    Ok(parts)
}

/// Reads all samples.
pub(super) fn changes<R: Read + Seek, F: FnMut(CaptureChange) -> ControlFlow<()>>(
    source: R,
    head: &Head,
    selected: &[usize],
    told: &mut Told<F>,
) -> Result<CaptureEnd, Wrong> {
    let mut archive = open(source)?;
    let mut samples = Samples::new(head, selected);
    for part in parts(&archive, &head.capture)? {
        let mut file = archive.by_name(&part).map_err(|cause| in_part(&part, cause))?;
        loop {
            let more = samples.fill(&mut file).map_err(|cause| in_part(&part, cause))?;
            match samples.scan(told) {
                Some(ControlFlow::Continue(())) => {}
                Some(ControlFlow::Break(())) => return samples.end(),
                None => return Err(in_part(&part, "the capture is too long")),
            }
            if !more {
                break;
            }
        }
    }
    samples.end()
}

/// Samples, a piece at a time.
struct Samples<'a> {
    head: &'a Head,
    /// Of each selected channel the byte of a sample and the bit in it.
    places: Vec<(usize, u8)>,
    /// The bits of a sample that are selected.
    mask: Vec<u8>,
    /// Of each byte the levels, where a sample is one.
    levels_of: Vec<u64>,
    known: u64,
    piece: Vec<u8>,
    /// Bytes of a sample whose rest is still to come.
    rest: usize,
    number: u64,
    before: Vec<u8>,
}

impl<'a> Samples<'a> {
    fn new(head: &'a Head, selected: &[usize]) -> Self {
        let mut mask = vec![0; head.unit];
        let bits = selected.iter().filter_map(|channel| head.bits.get(*channel));
        let places: Vec<_> = bits.map(|bit| (bit / 8, 1 << (bit % 8))).collect();
        for (byte, bit) in &places {
            if let Some(of) = mask.get_mut(*byte) {
                *of |= *bit;
            }
        }
        let known = if places.len() == 64 { u64::MAX } else { (1 << places.len()) - 1 };
        let levels_of = (0..=u8::MAX).map(|byte| levels(&places, &[byte])).collect();
        let piece = vec![0; PIECE.next_multiple_of(head.unit)];
        Self { head, places, mask, levels_of, known, piece, rest: 0, number: 0, before: Vec::new() }
    }

    /// Reads until the piece is full; `false` at the end of the part.
    fn fill(&mut self, file: &mut impl Read) -> io::Result<bool> {
        let mut filled = self.rest;
        while let Some(room) = self.piece.get_mut(filled..).filter(|room| !room.is_empty()) {
            match file.read(room) {
                Ok(0) => {
                    self.rest = filled;
                    return Ok(false);
                }
                Ok(bytes) => filled += bytes,
                Err(cause) if cause.kind() == io::ErrorKind::Interrupted => {}
                Err(cause) => return Err(cause),
            }
        }
        self.rest = filled;
        Ok(true)
    }

    /// Tells the changes of the whole samples in the piece; `None` if their times are too large.
    fn scan<F: FnMut(CaptureChange) -> ControlFlow<()>>(
        &mut self,
        told: &mut Told<F>,
    ) -> Option<ControlFlow<()>> {
        let unit = self.head.unit;
        let whole = self.rest / unit * unit;
        let piece = std::mem::take(&mut self.piece);
        let found = self.scan_samples(piece.get(..whole).unwrap_or_default(), told);
        self.piece = piece;
        self.piece.copy_within(whole..self.rest, 0);
        self.rest -= whole;
        found
    }

    fn scan_samples<F: FnMut(CaptureChange) -> ControlFlow<()>>(
        &mut self,
        samples: &[u8],
        told: &mut Told<F>,
    ) -> Option<ControlFlow<()>> {
        if let [mask] = self.mask[..] {
            return self.scan_bytes(mask, samples, told);
        }
        for sample in samples.chunks_exact(self.head.unit) {
            if self.before.is_empty() || self.differs(sample) {
                self.before.clear();
                self.before.extend_from_slice(sample);
                let time_ns = self.head.rate.time_ns(self.number)?;
                if told.tell(time_ns, levels(&self.places, sample), self.known).is_break() {
                    return Some(ControlFlow::Break(()));
                }
            }
            self.number = self.number.checked_add(1)?;
        }
        Some(ControlFlow::Continue(()))
    }

    /// Samples of one byte, as most analysers take them: what is alike is passed over by many at once.
    fn scan_bytes<F: FnMut(CaptureChange) -> ControlFlow<()>>(
        &mut self,
        mask: u8,
        mut samples: &[u8],
        told: &mut Told<F>,
    ) -> Option<ControlFlow<()>> {
        let mut before = self.before.first().copied();
        let found = loop {
            let same = before.map_or(0, |before| bytes_alike(samples, mask, before));
            self.number = self.number.checked_add(same as u64)?;
            let Some((&sample, behind)) = samples.get(same..).and_then(<[u8]>::split_first) else {
                break ControlFlow::Continue(());
            };
            let high = self.levels_of.get(usize::from(sample)).copied()?;
            if told.tell(self.head.rate.time_ns(self.number)?, high, self.known).is_break() {
                break ControlFlow::Break(());
            }
            self.number = self.number.checked_add(1)?;
            (before, samples) = (Some(sample), behind);
        };
        self.before.clear();
        self.before.extend(before);
        Some(found)
    }

    fn differs(&self, sample: &[u8]) -> bool {
        let bytes = sample.iter().zip(&self.before).zip(&self.mask);
        bytes.into_iter().any(|((now, before), mask)| (now ^ before) & mask != 0)
    }

    /// The last time that the samples tell of is that of the last one.
    fn end(&self) -> Result<CaptureEnd, Wrong> {
        if self.rest > 0 {
            let problem = format!("the samples end within one of {} bytes", self.head.unit);
            return Err(in_part(&self.head.capture, problem));
        }
        let last = self.head.rate.time_ns(self.number.saturating_sub(1));
        let time_ns = last.ok_or_else(|| in_file(io::ErrorKind::FileTooLarge.into()))?;
        Ok(CaptureEnd { time_ns, cut_in_line: None })
    }
}

/// What channels at these bits of these bytes show.
fn levels(places: &[(usize, u8)], sample: &[u8]) -> u64 {
    let high = |(byte, bit): &(usize, u8)| sample.get(*byte).is_some_and(|byte| byte & bit != 0);
    places.iter().zip(0..).map(|(place, number)| u64::from(high(place)) << number).sum()
}

/// How many bytes at the beginning are as `like` in the bits of `mask`. Most runs within a transfer are short.
#[inline]
fn bytes_alike(bytes: &[u8], mask: u8, like: u8) -> usize {
    let (wides, _) = bytes.as_chunks::<WIDE>();
    for (wide, number) in wides.iter().take(NEAR).zip(0..) {
        if let Some(alike) = end_of_run(wide, mask, like) {
            return number * WIDE + alike;
        }
    }
    let near = wides.len().min(NEAR) * WIDE;
    near + bytes_alike_far(bytes.get(near..).unwrap_or_default(), mask, like)
}

/// The same beyond the first few.
fn bytes_alike_far(bytes: &[u8], mask: u8, like: u8) -> usize {
    // Written so that the compiler takes wide registers.
    let is_alike = |block: &&[u8; FAR]| block.iter().fold(0, |unlike, byte| unlike | byte ^ like) & mask == 0;
    let (blocks, _) = bytes.as_chunks::<FAR>();
    let far = blocks.iter().take_while(is_alike).count() * FAR;
    let (wides, rest) = bytes.get(far..).unwrap_or_default().as_chunks::<WIDE>();
    let mut alike = far;
    for wide in wides {
        match end_of_run(wide, mask, like) {
            Some(more) => return alike + more,
            None => alike += WIDE,
        }
    }
    alike + rest.iter().take_while(|byte| (**byte ^ like) & mask == 0).count()
}

/// How many of these bytes are as `like` before the first that is not, if there is one.
#[inline]
fn end_of_run(wide: &[u8; WIDE], mask: u8, like: u8) -> Option<usize> {
    let all = |byte| u128::from_ne_bytes([byte; WIDE]);
    let unlike = (u128::from_le_bytes(*wide) ^ all(like)) & all(mask);
    (unlike != 0).then(|| unlike.trailing_zeros() as usize / 8)
}
