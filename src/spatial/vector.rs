//! Common operations of motions and forces as vectors of six coordinates.

/// Coordinates, sums and negatives of a spatial vector with the fields `linear` and `angular`.
macro_rules! spatial_vector {
    ($Vector:ident) => {
        impl<T: Additive> $Vector<T> {
            /// Makes a spatial vector from its linear and its angular part.
            #[inline(always)]
            pub fn new(linear: Vector3<T>, angular: Vector3<T>) -> Self {
                Self { linear, angular }
            }

            /// Makes the zero vector.
            #[inline(always)]
            pub fn zero() -> Self {
                Self::new(zero(), zero())
            }

            /// The k-th coordinate in the order `[linear; angular]`.
            ///
            /// # Panics
            /// If `k ≥ 6`.
            #[inline(always)]
            pub(crate) fn coordinate(&self, k: usize) -> T {
                if k < 3 {
                    self.linear[k]
                } else {
                    self.angular[k - 3]
                }
            }

            /// Coordinates `[linear; angular]`.
            #[inline(always)]
            pub fn to_array(&self) -> [T; SPATIAL] {
                let (l, a) = (&self.linear, &self.angular);
                [l.x, l.y, l.z, a.x, a.y, a.z]
            }

            /// References to the coordinates `[linear; angular]`.
            #[inline(always)]
            pub(crate) fn entries(&self) -> [&T; SPATIAL] {
                let (l, a) = (&self.linear, &self.angular);
                [&l.x, &l.y, &l.z, &a.x, &a.y, &a.z]
            }

            /// Makes a spatial vector from its six coordinates `[linear; angular]`.
            #[inline(always)]
            pub fn from_array([x, y, z, rx, ry, rz]: [T; SPATIAL]) -> Self {
                Self::new(Vector3::new(x, y, z), Vector3::new(rx, ry, rz))
            }
        }

        impl<T: Additive> Add for $Vector<T> {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                Self::new(self.linear + other.linear, self.angular + other.angular)
            }
        }

        impl<T: Additive> AddAssign for $Vector<T> {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }

        impl<T: Additive> Sub for $Vector<T> {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                Self::new(self.linear - other.linear, self.angular - other.angular)
            }
        }

        impl<T: Additive> Neg for $Vector<T> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self::new(-self.linear, -self.angular)
            }
        }
    };
}

pub(super) use spatial_vector;
