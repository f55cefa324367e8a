#include "common/slam/loops/pose_graph.h"

// Eigen as a digest may use it, here and nowhere else (tests/system/structure_test.sh). Its vectors fuse
// multiplications with additions where the instruction set can, whatever the compiler is told about
// contraction, and their width decides the order of sums.
#undef EIGEN_DONT_VECTORIZE
#define EIGEN_DONT_VECTORIZE 1
#undef EIGEN_DONT_PARALLELIZE
#define EIGEN_DONT_PARALLELIZE 1
// Newer versions may fuse scalars as well.
#undef EIGEN_SCALAR_MADD_USE_FMA
#define EIGEN_SCALAR_MADD_USE_FMA 0
// A program that links this library may use Eigen itself, with other flags. A linker takes one of two
// functions of the same name: these must have other names than those.
#define Eigen parloc_plain_eigen
#include <Eigen/Core>
#include <Eigen/SparseCholesky>

#include <algorithm>
#include <cmath>

#include "common/math/portable64.h"

namespace parloc {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Triplets = std::vector<Eigen::Triplet<double>>;

Eigen::Vector3d misfit(const Pose& from, const Pose& to, const Pose& step) {
  const Pose seen = relative(to, from);
  return {seen.x_m - step.x_m, seen.y_m - step.y_m, wrap64(seen.theta_rad - step.theta_rad)};
}

/// The normal equations of one round. The first pose stands still: pose k is unknowns 3 (k - 1) and on.
struct Normal {
  explicit Normal(std::size_t poses)
      : gradient(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * (poses - 1)))) {}

  void add(const std::vector<Pose>& poses, const PoseEdge& e, const Eigen::Matrix3d& information,
           double kernel) {
    const Pose &a = poses[e.from], &b = poses[e.to];
    const SinCos64 r = portable_sincos64(a.theta_rad);
    const Pose seen = relative(b, a);
    Eigen::Matrix3d by_from, by_to;
    by_from << -r.cos, -r.sin, seen.y_m, r.sin, -r.cos, -seen.x_m, 0.0, 0.0, -1.0;
    by_to << r.cos, r.sin, 0.0, -r.sin, r.cos, 0.0, 0.0, 0.0, 1.0;
    const Eigen::Vector3d error = misfit(a, b, e.step);
    Eigen::Matrix3d weight = information;
    if (e.may_be_wrong) weight /= 1.0 + error.dot(information * error) / (kernel * kernel);
    const Eigen::Matrix3d from = weight * by_from, to = weight * by_to;
    add_block(e.from, e.from, by_from.transpose() * from);
    add_block(e.to, e.to, by_to.transpose() * to);
    if (e.from > e.to) add_block(e.from, e.to, by_from.transpose() * to);
    if (e.to > e.from) add_block(e.to, e.from, by_to.transpose() * from);
    add_gradient(e.from, by_from.transpose() * (weight * error));
    add_gradient(e.to, by_to.transpose() * (weight * error));
  }
  Sparse matrix() const {
    Sparse m(gradient.size(), gradient.size());
    m.setFromTriplets(entry.begin(), entry.end());
    return m;
  }

  Triplets entry;  ///< Lower half.
  Eigen::VectorXd gradient;

 private:
  void add_block(std::size_t row, std::size_t column, const Eigen::Matrix3d& block) {
    if (row == 0 || column == 0) return;
    const int i = static_cast<int>(3 * (row - 1)), j = static_cast<int>(3 * (column - 1));
    for (int p = 0; p < 3; ++p)
      for (int q = 0; q < 3; ++q)
        if (i + p >= j + q) entry.emplace_back(i + p, j + q, block(p, q));
  }
  void add_gradient(std::size_t row, const Eigen::Vector3d& part) {
    if (row > 0) gradient.segment<3>(static_cast<Eigen::Index>(3 * (row - 1))) += part;
  }
};

Eigen::Matrix3d information_of(const PoseEdge& e) {
  const Matrix3 inverted = inverse(cholesky(e.covariance));
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(inverted.m);
}

bool is_sound(const std::vector<Pose>& poses, const std::vector<PoseEdge>& edges) {
  return std::all_of(edges.begin(), edges.end(), [&](const PoseEdge& e) {
    return e.from < poses.size() && e.to < poses.size() && e.from != e.to && cholesky(e.covariance).ok;
  });
}

}  // namespace

double misfit_sq(const std::vector<Pose>& poses, const PoseEdge& edge) {
  const Eigen::Vector3d error = misfit(poses[edge.from], poses[edge.to], edge.step);
  return error.dot(information_of(edge) * error);
}

void relax(std::vector<Pose>& poses, const std::vector<PoseEdge>& edges, const PoseGraphRules& rules) {
  if (poses.size() < 2 || !is_sound(poses, edges)) return;
  std::vector<Eigen::Matrix3d> information;
  information.reserve(edges.size());
  for (const PoseEdge& e : edges) information.push_back(information_of(e));
  Eigen::SimplicialLDLT<Sparse> solver;
  for (int round = 0; round < rules.rounds; ++round) {
    Normal normal(poses.size());
    for (std::size_t k = 0; k < edges.size(); ++k) normal.add(poses, edges[k], information[k], rules.kernel);
    const Sparse matrix = normal.matrix();
    if (round == 0) solver.analyzePattern(matrix);  // which edges there are does not change
    solver.factorize(matrix);
    if (solver.info() != Eigen::Success) return;
    const Eigen::VectorXd step = solver.solve(-normal.gradient);
    if (!step.allFinite()) return;
    for (std::size_t k = 1; k < poses.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(3 * (k - 1));
      Pose& p = poses[k];
      p = {p.x_m + step[at], p.y_m + step[at + 1], wrap64(p.theta_rad + step[at + 2])};
    }
    if (step.cwiseAbs().maxCoeff() < rules.least_step) return;
  }
}

}  // namespace parloc
