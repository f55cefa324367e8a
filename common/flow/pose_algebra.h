// Vectors and symmetric matrices of (x, y, theta) in float64, with one order of operations.
#pragma once

#include "common/math/host_device.h"
#include "common/math/portable64.h"

namespace parloc {

struct Vector3 {
  double v[3] = {0, 0, 0};
  PARLOC_HD double& operator[](int i) { return v[i]; }
  PARLOC_HD double operator[](int i) const { return v[i]; }
};

/// Row-major.
struct Matrix3 {
  double m[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
  PARLOC_HD double& operator()(int i, int j) { return m[3 * i + j]; }
  PARLOC_HD double operator()(int i, int j) const { return m[3 * i + j]; }
};

PARLOC_HD double dot(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// a + scale * b
PARLOC_HD Vector3 plus(const Vector3& a, double scale, const Vector3& b) {
  Vector3 c;
  for (int i = 0; i < 3; ++i) c[i] = a[i] + scale * b[i];
  return c;
}

PARLOC_HD Matrix3 identity3() {
  Matrix3 m;
  m(0, 0) = m(1, 1) = m(2, 2) = 1.0;
  return m;
}

PARLOC_HD Matrix3 diagonal3(double a, double b, double c) {
  Matrix3 m;
  m(0, 0) = a, m(1, 1) = b, m(2, 2) = c;
  return m;
}

PARLOC_HD Vector3 multiply(const Matrix3& a, const Vector3& x) {
  Vector3 y;
  for (int i = 0; i < 3; ++i) y[i] = a(i, 0) * x[0] + a(i, 1) * x[1] + a(i, 2) * x[2];
  return y;
}

/// a * b^T
PARLOC_HD Matrix3 multiply_transposed(const Matrix3& a, const Matrix3& b) {
  Matrix3 c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) c(i, j) = a(i, 0) * b(j, 0) + a(i, 1) * b(j, 1) + a(i, 2) * b(j, 2);
  return c;
}

PARLOC_HD Matrix3 multiply(const Matrix3& a, const Matrix3& b) {
  Matrix3 c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) c(i, j) = a(i, 0) * b(0, j) + a(i, 1) * b(1, j) + a(i, 2) * b(2, j);
  return c;
}

/// a p a^T
PARLOC_HD Matrix3 sandwich(const Matrix3& a, const Matrix3& p) {
  return multiply_transposed(multiply(a, p), a);
}

/// a + scale * b b^T
PARLOC_HD Matrix3 plus_outer(const Matrix3& a, double scale, const Vector3& b) {
  Matrix3 c = a;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) c(i, j) = a(i, j) + scale * (b[i] * b[j]);
  return c;
}

PARLOC_HD Matrix3 symmetrised(const Matrix3& a) {
  Matrix3 c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) c(i, j) = 0.5 * (a(i, j) + a(j, i));
  return c;
}

/// a = l l^T; not ok: a is not positive definite, and l of no use.
struct Cholesky3 {
  Matrix3 l;
  bool ok = false;
};
PARLOC_HD Cholesky3 cholesky(const Matrix3& a) {
  Cholesky3 c;
  for (int j = 0; j < 3; ++j) {
    double pivot = a(j, j);
    for (int k = 0; k < j; ++k) pivot -= c.l(j, k) * c.l(j, k);
    if (!(pivot > 0.0)) return c;
    c.l(j, j) = __builtin_sqrt(pivot);
    for (int i = j + 1; i < 3; ++i) {
      double sum = a(i, j);
      for (int k = 0; k < j; ++k) sum -= c.l(i, k) * c.l(j, k);
      c.l(i, j) = sum / c.l(j, j);
    }
  }
  c.ok = true;
  return c;
}

/// l of a = l l^T for a that may be singular: what has no variance of its own gets none.
PARLOC_HD Matrix3 semidefinite_root(const Matrix3& a) {
  Matrix3 l;
  for (int j = 0; j < 3; ++j) {
    double pivot = a(j, j);
    for (int k = 0; k < j; ++k) pivot -= l(j, k) * l(j, k);
    if (!(pivot > 1e-12 * a(j, j))) continue;  // rounding
    l(j, j) = __builtin_sqrt(pivot);
    for (int i = j + 1; i < 3; ++i) {
      double sum = a(i, j);
      for (int k = 0; k < j; ++k) sum -= l(i, k) * l(j, k);
      l(i, j) = sum / l(j, j);
    }
  }
  return l;
}

/// y of l y = b.
PARLOC_HD Vector3 solve_lower(const Matrix3& l, const Vector3& b) {
  Vector3 y;
  y[0] = b[0] / l(0, 0);
  y[1] = (b[1] - l(1, 0) * y[0]) / l(1, 1);
  y[2] = (b[2] - l(2, 0) * y[0] - l(2, 1) * y[1]) / l(2, 2);
  return y;
}

/// x of l l^T x = b.
PARLOC_HD Vector3 solve(const Cholesky3& c, const Vector3& b) {
  const Vector3 y = solve_lower(c.l, b);
  Vector3 x;
  x[2] = y[2] / c.l(2, 2);
  x[1] = (y[1] - c.l(2, 1) * x[2]) / c.l(1, 1);
  x[0] = (y[0] - c.l(1, 0) * x[1] - c.l(2, 0) * x[2]) / c.l(0, 0);
  return x;
}

PARLOC_HD Matrix3 inverse(const Cholesky3& c) {
  Matrix3 inv;
  for (int j = 0; j < 3; ++j) {
    Vector3 unit;
    unit[j] = 1.0;
    const Vector3 column = solve(c, unit);
    for (int i = 0; i < 3; ++i) inv(i, j) = column[i];
  }
  return symmetrised(inv);
}

/// d^T a^-1 d + log det a, of the factor of a: twice the negative log density but for its constant.
PARLOC_HD double gaussian_exponent(const Cholesky3& c, const Vector3& d) {
  const Vector3 y = solve_lower(c.l, d);
  const double diagonal = c.l(0, 0) * c.l(1, 1) * c.l(2, 2);
  return dot(y, y) + 2.0 * portable_log64(diagonal);
}

/// Least eigenvalue of a covariance (SPEC 7.10): below it rounding, or a start without any spread, would make
/// it singular.
constexpr double kLeastVariance = 1e-12;

/// Symmetric, and with no eigenvalue below kLeastVariance.
PARLOC_HD Matrix3 proper_covariance(const Matrix3& a) {
  Matrix3 p = symmetrised(a);
  double raise = kLeastVariance;
  for (int tries = 0; tries < 60; ++tries) {
    Matrix3 above = p;
    for (int i = 0; i < 3; ++i) above(i, i) -= 0.999 * kLeastVariance;  // what was raised from 0 passes
    if (cholesky(above).ok) break;
    for (int i = 0; i < 3; ++i) p(i, i) += raise;
    raise *= 2.0;
  }
  return p;
}

/// a (+) e of the error state: component by component, heading wrapped (SPEC 0.1).
PARLOC_HD Vector3 box_plus(const Vector3& a, const Vector3& e) {
  Vector3 x;
  x[0] = a[0] + e[0], x[1] = a[1] + e[1], x[2] = wrap64(a[2] + e[2]);
  return x;
}

/// x (-) a, the error that leads from a to x.
PARLOC_HD Vector3 box_minus(const Vector3& x, const Vector3& a) {
  Vector3 e;
  e[0] = x[0] - a[0], e[1] = x[1] - a[1], e[2] = wrap64(x[2] - a[2]);
  return e;
}

}  // namespace parloc
