//! Real roots of polynomials, by closed forms that do not cancel and by bracketing.
