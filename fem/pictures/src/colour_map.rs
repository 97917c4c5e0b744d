//! Colours: perceptually uniform colour maps and a palette for lines and regions.

/// A colour in sRGB with an opacity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Colour {
    /// Red, green and blue in sRGB.
    pub rgb: [u8; 3],
    /// Opacity between 0 (invisible) and 1 (opaque).
    pub opacity: f32,
}

impl Colour {
    /// Black, opaque.
    pub const BLACK: Colour = Colour::grey(0);
    /// White, opaque.
    pub const WHITE: Colour = Colour::grey(255);

    /// An opaque colour from its code `0xRRGGBB`.
    pub const fn hexadecimal(code: u32) -> Colour {
        Colour { rgb: [(code >> 16) as u8, (code >> 8) as u8, code as u8], opacity: 1.0 }
    }

    /// An opaque grey from 0 (black) to 255 (white).
    pub const fn grey(level: u8) -> Colour {
        Colour { rgb: [level; 3], opacity: 1.0 }
    }

    /// This colour with another opacity.
    pub const fn with_opacity(self, opacity: f32) -> Colour {
        Colour { opacity, ..self }
    }

    /// The `index`-th colour for lines and regions; after the last one it begins again.
    ///
    /// Paul Tol's "bright" scheme, which colour-blind readers can tell apart.
    pub fn of_series(index: usize) -> Colour {
        const SERIES: [u32; 6] = [0x4477aa, 0xee6677, 0x228833, 0xccbb44, 0xaa3377, 0x66ccee];
        Colour::hexadecimal(SERIES[index % SERIES.len()])
    }
}

/// A map from [0, 1] to colours of even perceptual steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum ColourMap {
    /// Sequential, dark blue to yellow (S. van der Walt and N. Smith, public domain).
    #[default]
    Viridis,
    /// Diverging, blue over white to red, for signed data (F. Crameri, Scientific colour maps, MIT licence).
    Vik,
}

impl ColourMap {
    /// The colour at `t`; below 0 and above 1 the end colours hold.
    pub fn at(self, t: f64) -> Colour {
        let table = match self {
            ColourMap::Viridis => &VIRIDIS,
            ColourMap::Vik => &VIK,
        };
        let place = t.clamp(0.0, 1.0) * (table.len() - 1) as f64;
        let lower = (place as usize).min(table.len() - 2);
        let weight = place - lower as f64;
        let (a, b) = (Colour::hexadecimal(table[lower]).rgb, Colour::hexadecimal(table[lower + 1]).rgb);
        let rgb = std::array::from_fn(|k| {
            (f64::from(a[k]) * (1.0 - weight) + f64::from(b[k]) * weight).round() as u8
        });
        Colour { rgb, opacity: 1.0 }
    }
}

/// 65 even samples of the published table of 256 colours: linear interpolation is within one unit of it.
#[rustfmt::skip]
const VIRIDIS: [u32; 65] = [
    0x440154, 0x46065a, 0x470d60, 0x471365, 0x48186a, 0x481d6f, 0x482374, 0x482878, 0x472d7b, 0x46327e,
    0x453681, 0x443b84, 0x424086, 0x404587, 0x3f4989, 0x3d4e8a, 0x3b528b, 0x39568c, 0x375a8d, 0x355e8d,
    0x33638d, 0x31668e, 0x2f6a8e, 0x2e6e8e, 0x2c728e, 0x2b768e, 0x297a8e, 0x287d8e, 0x26818e, 0x25858e,
    0x23898e, 0x228c8d, 0x21908c, 0x20948c, 0x1f988b, 0x1e9b8a, 0x1f9f88, 0x20a387, 0x21a685, 0x24aa83,
    0x28ae80, 0x2cb17e, 0x31b57b, 0x37b877, 0x3ebc74, 0x45bf70, 0x4cc26c, 0x54c667, 0x5dc963, 0x65cc5d,
    0x6ece58, 0x78d152, 0x82d34c, 0x8cd646, 0x96d83f, 0xa0da39, 0xabdc32, 0xb5de2b, 0xc0df24, 0xcbe11f,
    0xd5e21a, 0xe0e318, 0xeae51a, 0xf4e61e, 0xfde725,
];

/// 65 even samples of the published table of 256 colours: linear interpolation is within one unit of it.
#[rustfmt::skip]
const VIK: [u32; 65] = [
    0x001261, 0x011865, 0x021f69, 0x02256d, 0x022b71, 0x023175, 0x023779, 0x033d7d, 0x034481, 0x034a85,
    0x045089, 0x07578d, 0x0c5e92, 0x136596, 0x1b6d9b, 0x2574a1, 0x2f7ca6, 0x3b85ac, 0x478db1, 0x5395b7,
    0x609dbc, 0x6ca5c2, 0x79adc7, 0x86b5cd, 0x92bdd2, 0x9fc5d7, 0xacccdc, 0xb8d4e1, 0xc5dbe5, 0xd1e1e9,
    0xdce5e9, 0xe6e7e7, 0xece5e1, 0xeee1d9, 0xeedacf, 0xecd3c4, 0xe9cbb9, 0xe6c3ae, 0xe2bba4, 0xdfb399,
    0xdcab8f, 0xd9a485, 0xd59c7b, 0xd29571, 0xcf8e68, 0xcc865e, 0xc97f55, 0xc6784c, 0xc37243, 0xc06a3a,
    0xbc6331, 0xb85b28, 0xb3531f, 0xad4a16, 0xa5400e, 0x9c3709, 0x932e06, 0x8b2706, 0x832106, 0x7c1b06,
    0x741506, 0x6d1007, 0x660a07, 0x600408, 0x590008,
];

#[cfg(test)]
mod tests {
    use super::*;

    /// The published colours at the ends and, for the diverging map, a nearly white middle.
    #[test]
    fn end_points_are_the_published_colours() {
        assert_eq!(ColourMap::Viridis.at(0.0).rgb, [68, 1, 84]);
        assert_eq!(ColourMap::Viridis.at(1.0).rgb, [253, 231, 37]);
        assert_eq!(ColourMap::Viridis.at(-3.0), ColourMap::Viridis.at(0.0));
        assert_eq!(ColourMap::Vik.at(0.0).rgb, [0, 18, 97]);
        assert_eq!(ColourMap::Vik.at(7.0).rgb, [89, 0, 8]);
        assert!(ColourMap::Vik.at(0.5).rgb.iter().all(|&channel| channel > 220));
    }

    /// CIE lightness of viridis grows along the map: that is what a sequential map is for.
    #[test]
    fn luminance_of_viridis_grows() {
        let luminance = |t: f64| {
            let linear = |channel: u8| (f64::from(channel) / 255.0).powf(2.2);
            let [r, g, b] = ColourMap::Viridis.at(t).rgb;
            0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b)
        };
        let samples: Vec<f64> = (0..=64).map(|k| luminance(f64::from(k) / 64.0)).collect();
        assert!(samples.windows(2).all(|pair| pair[1] > pair[0]));
    }
}
