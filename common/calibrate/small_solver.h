// Least squares of a few unknowns.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace parloc {

/// Symmetric, positive definite systems of N equations at most; the first `size` count.
template <std::size_t N>
struct NormalEquations {
  std::array<std::array<double, N>, N> matrix{};
  std::array<double, N> right{};

  /// Adds weight * row * row^T, and weight * value * row on the right.
  void add(const std::array<double, N>& row, double value, double weight) {
    for (std::size_t i = 0; i < N; ++i) {
      if (row[i] == 0.0) continue;
      right[i] += weight * row[i] * value;
      for (std::size_t j = 0; j <= i; ++j) matrix[i][j] += weight * row[i] * row[j];
    }
  }

  /// The lower triangle of the Cholesky factor in place of the matrix; false if it is not positive definite.
  bool factor() {
    for (std::size_t j = 0; j < N; ++j) {
      for (std::size_t i = j; i < N; ++i) {
        double sum = matrix[i][j];
        for (std::size_t k = 0; k < j; ++k) sum -= matrix[i][k] * matrix[j][k];
        if (i == j) {
          if (!(sum > 0.0)) return false;
          matrix[j][j] = std::sqrt(sum);
        } else {
          matrix[i][j] = sum / matrix[j][j];
        }
      }
    }
    return true;
  }
  /// After factor().
  std::array<double, N> solve(std::array<double, N> b) const {
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t k = 0; k < i; ++k) b[i] -= matrix[i][k] * b[k];
      b[i] /= matrix[i][i];
    }
    for (std::size_t i = N; i-- > 0;) {
      for (std::size_t k = i + 1; k < N; ++k) b[i] -= matrix[k][i] * b[k];
      b[i] /= matrix[i][i];
    }
    return b;
  }
  /// Column j of the inverse, after factor().
  std::array<double, N> inverse_column(std::size_t j) const {
    std::array<double, N> unit{};
    unit[j] = 1.0;
    return solve(unit);
  }
};

using Matrix3 = std::array<std::array<double, 3>, 3>;

/// Of a symmetric, positive definite matrix; false if it is not.
inline bool invert(const Matrix3& m, Matrix3& inverse) {
  NormalEquations<3> equations;
  equations.matrix = m;
  if (!equations.factor()) return false;
  for (std::size_t j = 0; j < 3; ++j) {
    const std::array<double, 3> column = equations.inverse_column(j);
    for (std::size_t i = 0; i < 3; ++i) inverse[i][j] = column[i];
  }
  return true;
}

}  // namespace parloc
