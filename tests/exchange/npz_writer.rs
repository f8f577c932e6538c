use std::io::{Result, Write};

/// Arrays as a `.npz`: a ZIP archive, nothing compressed, with one `.npy` an array. For little-endian machines, and files
/// below 4 GB.
#[derive(Default)]
pub struct NpzWriter {
    bytes: Vec<u8>,
    directory: Vec<u8>,
    count: u16,
}

impl NpzWriter {
    /// `kind` is `<f4` or `<i4`; `shape` is as Python writes it, as in `(10, 2, 3)` or `(7,)`.
    pub fn add(&mut self, name: &str, kind: &str, shape: &str, data: &[u8]) {
        let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
        while (10 + header.len() + 1) % 64 != 0 {
            header.push(' ');
        }
        header.push('\n');
        let mut body = b"\x93NUMPY\x01\0".to_vec();
        body.extend((header.len() as u16).to_le_bytes());
        body.extend(header.bytes());
        body.extend(data);
        let name = format!("{name}.npy");
        // Version, flags, method, time, date.
        let mut about = [20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0].to_vec();
        about.extend(crc32(&body).to_le_bytes());
        about.extend((body.len() as u32).to_le_bytes());
        about.extend((body.len() as u32).to_le_bytes());
        about.extend((name.len() as u16).to_le_bytes());
        about.extend([0, 0]);
        let start = self.bytes.len() as u32;
        self.bytes.extend([b"PK\x03\x04", &about[..], name.as_bytes(), &body].concat());
        self.directory.extend([b"PK\x01\x02\x14\0", &about[..], &[0; 10], &start.to_le_bytes()[..]].concat());
        self.directory.extend(name.bytes());
        self.count += 1;
    }

    pub fn finish(self, mut file: impl Write) -> Result<()> {
        file.write_all(&self.bytes)?;
        file.write_all(&self.directory)?;
        file.write_all(b"PK\x05\x06\0\0\0\0")?;
        file.write_all(&[self.count.to_le_bytes(), self.count.to_le_bytes()].concat())?;
        file.write_all(&(self.directory.len() as u32).to_le_bytes())?;
        file.write_all(&(self.bytes.len() as u32).to_le_bytes())?;
        file.write_all(&[0, 0])
    }
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, &byte| {
        (0..8).fold(
            crc ^ u32::from(byte),
            |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 },
        )
    })
}
