/// A rectangle of pixels; `x` and `y` are its top left pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    /// Leftmost column.
    pub x: u32,
    /// Topmost row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Rect {
    /// A whole picture of `size` pixels, width and height.
    pub fn of_size(size: (u32, u32)) -> Self {
        Self {
            x: 0,
            y: 0,
            width: size.0,
            height: size.1,
        }
    }

    /// Squares of `edge` pixels that cover the rectangle once, row by row; those at the right and bottom may be smaller.
    ///
    /// # Panics
    /// Where `edge` is 0.
    pub fn tiles(self, edge: u32) -> impl Iterator<Item = Self> + Clone {
        let steps = move |length: u32| {
            (0..length)
                .step_by(edge as usize)
                .map(move |start| (start, edge.min(length - start)))
        };
        steps(self.height).flat_map(move |(y, height)| {
            steps(self.width).map(move |(x, width)| Self {
                x: self.x + x,
                y: self.y + y,
                width,
                height,
            })
        })
    }

    /// Column and row of each of its pixels, row by row.
    pub fn pixels(self) -> impl Iterator<Item = (u32, u32)> + Clone {
        let columns = self.x..self.x + self.width;
        (self.y..self.y + self.height).flat_map(move |y| columns.clone().map(move |x| (x, y)))
    }

    /// The same in squares of eight by eight, and in these along a Z, so that rays through pixels that follow each other
    /// go together, however many: 8 are four by two, 16 four by four.
    pub fn blocks(self) -> impl Iterator<Item = (u32, u32)> + Clone {
        let fours = self.tiles(8).flat_map(|square| square.tiles(4));
        fours
            .flat_map(|square| square.tiles(2))
            .flat_map(Self::pixels)
    }

    /// Whether all of `other` lies inside.
    pub fn contains(self, other: Self) -> bool {
        let inside = |start, length, other_start, other_length| {
            start <= other_start
                && other_start - start <= length
                && other_length <= length - (other_start - start)
        };
        inside(self.x, self.width, other.x, other.width)
            && inside(self.y, self.height, other.y, other.height)
    }
}
