// Flow and Kalman updates in float64: the check values of SPEC 1.4, 7.6, 7.8, 7.9, 7.11, 8.1 and 8.2, on a
// linear problem where the posterior is known.
#include "common/flow/exact_flow.h"

#include <gtest/gtest.h>

#include "common/flow/cloud_move.h"
#include "common/flow/mean_update.h"
#include "common/flow/particle_flow.h"
#include "tests/unit/flow_scenes.h"

namespace parloc {
namespace {

using test::vector3;

constexpr double kExact = 1e-11;  // the specification prints twelve decimals

Matrix3 matrix3(const std::array<double, 9>& m) {
  Matrix3 a;
  for (int i = 0; i < 9; ++i) a.m[i] = m[static_cast<std::size_t>(i)];
  return a;
}
void expect_near(const Vector3& a, const Vector3& b, double tolerance) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << i;
}
void expect_near(const Matrix3& a, const Matrix3& b, double tolerance) {
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(a.m[i], b.m[i], tolerance) << i;
}
void expect_diagonal(const Matrix3& a, const Vector3& diagonal, double tolerance) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a(i, i), diagonal[i], tolerance) << i;
}

/// The linear problem of 7.11: 3 = H x + noise.
struct Toy {
  Matrix3 p = matrix3({0.04, 0.01, 0.002, 0.01, 0.09, -0.003, 0.002, -0.003, 0.0025});
  Vector3 m0 = vector3(1, -2, 0.5), h = vector3(0.6, -0.8, 1.5);
  double r = 0.01;
  Vector3 k = multiply(p, h);
  double s = dot(h, k);
  double y = 3.0 - dot(h, m0);
  Vector3 x0 = vector3(1.3, -2.2, 0.55);
  Vector3 mean = vector3(1.010695187166, -2.039684773431, 0.504137348719);
  Matrix3 covariance =
      matrix3({0.035935828877, 0.025080213904, 0.000427807487, 0.025080213904, 0.034044469462, 0.002833661694,
               0.000427807487, 0.002833661694, 0.001891809738});

  /// What a scan would say at a pose, if psi were linear.
  FieldMeasurement at(const Vector3& x) const {
    FieldMeasurement z;
    z.psi_m = z.pull_m = dot(h, x) - 3.0;
    z.slope = h;
    z.beams = 1;
    return z;
  }
  FlowStep closed_form(const Stretch& t) const { return closed_form_step(t, s, r, y); }
  FlowStep euler(const Stretch& t) const { return euler_step(t, s, r, y); }
  FlowStep gromov(const Stretch& t) const { return gromov_step(t, s, r, y); }
  /// How far x0 is from m0 after a step.
  Vector3 moved(const FlowStep& step) const { return flowed(box_minus(x0, m0), step, k, h); }

  using Form = FlowStep (Toy::*)(const Stretch& t) const;
  Vector3 flow(Form form, const FlowTimes& times) const {
    Vector3 e = box_minus(x0, m0);
    for (int j = 0; j < times.steps; ++j) e = flowed(e, (this->*form)(times.stretch(j, s / r)), k, h);
    return box_plus(m0, e);
  }
  Vector3 flow(Form form, FlowSchedule schedule, int steps, double ratio) const {
    return flow(form, flow_times(schedule, steps, ratio));
  }
};

TEST(PoseGaussian, PredictionHasTheValuesOfTheSpecification) {
  const OdometryIncrement d = odometry_increment({1, 2, 0.5}, {1.3, 2.4, 0.9}, 0.01);
  const double s1 = 0.067729521800161, st = 0.049091808720064, s2 = 0.027729521800161;
  const MotionNoise u{d.rot1_rad, d.trans_m, d.rot2_rad, vector3(s1 * s1, st * st, s2 * s2)};
  const PoseGaussian g = predicted({vector3(5, -1, -2), diagonal3(0.01, 0.02, 0.005)}, u);
  expect_near(g.mean, vector3(4.999045772978, -1.499999089450, -1.6), kExact);
  const double xx = 0.01239682207884, xy = 2.516034928935e-8, xt = 0.004793635331934, yy = 0.02241000563539,
               yt = -9.148449399703e-6, tt = 0.01035621450254;
  expect_near(g.covariance, matrix3({xx, xy, xt, xy, yy, yt, xt, yt, tt}), 1e-14);
}

TEST(ScalarEkf, HasTheValuesOfTheSpecification) {
  const test::MapField t1(test::map_t1(), test::kNoCap_m);
  const BeamTable beams = test::example_beams();
  const FieldMeasurement z = test::measure(t1.field, beams, test::example_pose());
  const PoseGaussian prior{test::example_pose(), diagonal3(0.01, 0.01, 0.0025)};
  const auto updated = [&](double r, const Vector3& mean, double tolerance, double psi_m) {
    const PoseGaussian after = kalman_update(prior, z, r);
    const Vector3 origin = vector3(-1, -2, 0);  // of T1's grid
    expect_near(plus(after.mean, 1.0, origin), mean, tolerance);
    EXPECT_NEAR(test::measure(t1.field, beams, after.mean).psi_m, psi_m, 1e-4);
    return after;
  };
  // z is a float32 sum, and the gain has some ten times its error.
  updated(psi_variance(z, {0.02 * 0.02, 0.0}), vector3(0.311317602129, -0.175421135846, -0.139594270920),
          1e-5, 0.4577);
  const double r = psi_variance(z, {0.02 * 0.02, 0.1 * 0.1});
  const PoseGaussian after =
      updated(r, vector3(0.738361130062, 0.108953727094, 0.157166030149), 5e-6, 0.3081);
  expect_diagonal(after.covariance, vector3(0.009643159498, 0.009841761462, 0.002327677709), 1e-8);
  EXPECT_NEAR(gate(prior.covariance, z, r, {}).nis, 10.647194651, 1e-4);
}

TEST(ScalarEkf, StepsNoFartherThanTheFieldReaches) {
  FieldMeasurement z;
  z.psi_m = z.pull_m = 0.4;
  z.slope = vector3(0.05, 0.0, 0.1);  // small: walls of all directions cancel out
  z.arm_m = 3.0;
  z.beams = 100;
  const PoseGaussian prior{vector3(2, 2, 0), diagonal3(0.01, 0.01, 0.04)};
  const auto end_points_move = [&](double variance) {
    const Vector3 step = box_minus(kalman_update(prior, z, variance).mean, prior.mean);
    return std::hypot(step[0], step[1]) + std::fabs(step[2]) * z.arm_m;
  };
  constexpr double r = 1e-4, most_m = 1.0;
  EXPECT_GT(end_points_move(r), 5.0);
  EXPECT_NEAR(end_points_move(short_step_variance(prior.covariance, z, r, most_m)), most_m, 1e-9);
  EXPECT_EQ(short_step_variance(prior.covariance, z, r, 100.0), r);  // short enough as it is
}

TEST(ScalarEkf, TheGateInflatesOrRejects) {
  Toy toy;
  const FieldMeasurement z = toy.at(vector3(2, -2, 0.5));  // NIS 4.05
  EXPECT_FALSE(gate(toy.p, z, toy.r, {FlowGate::off, 1.0}).rejected);
  EXPECT_TRUE(gate(toy.p, z, toy.r, {FlowGate::reject, 1.0}).rejected);
  EXPECT_FALSE(gate(toy.p, z, toy.r, {FlowGate::reject, 5.0}).rejected);
  const GatedNoise inflated = gate(toy.p, z, toy.r, {FlowGate::inflate, 2.0});
  EXPECT_FALSE(inflated.rejected);
  EXPECT_NEAR(inflated.variance, toy.r * inflated.nis / 2.0, 1e-15);
}

TEST(VectorEkf, HasTheValuesOfTheSpecification) {
  const test::MapField t1(test::map_t1(), test::kNoCap_m);
  const auto scan = std::make_unique<cpu::PaddedScan>();
  const auto notes = std::make_unique<cpu::BeamNotes>();
  const BeamTable beams = test::example_beams();
  scan->set(beams);
  // sigma_map 0.1 m in cells of 0.5 m; sigma_r 0.02 m
  const InformationTerms terms{0.04f * 0.04f, 0.2f * 0.2f, 1.0f};
  const auto sum = cpu::sum_beams(t1.field, *scan, scan_pose(test::example_pose(), t1.field), terms, *notes);
  const PoseGaussian prior{test::example_pose(), diagonal3(0.01, 0.01, 0.0025)};
  const InformationStep step = information_step(prior, prior.mean, finish_information(sum, t1.field));
  ASSERT_TRUE(step.ok);
  expect_near(step.step, vector3(-0.159893979230, -0.047468237894, -0.122310218411), 2e-6);
  expect_diagonal(step.covariance, vector3(0.003430594599, 0.003502117488, 0.001818715401), 1e-8);
}

TEST(ExactFlow, SchedulesHaveTheValuesOfTheSpecification) {
  const FlowTimes exp29 = flow_times(FlowSchedule::exponential, 29, 1.2);
  EXPECT_NEAR(exp29.stretch(0, 1).length(), 0.0010161899647712859, 1e-15);
  EXPECT_NEAR(exp29.stretch(28, 1).length(), 0.1675134916373094, 1e-14);
  const FlowTimes exp10 = flow_times(FlowSchedule::exponential, 10, 1.3);
  EXPECT_NEAR(exp10.stretch(0, 1).length(), 0.023463439593, kExact);
  EXPECT_NEAR(exp10.stretch(9, 1).length(), 0.248818030456, kExact);
  EXPECT_NEAR(flow_times(FlowSchedule::exponential, 20, 2.0).stretch(0, 1).length(), 9.536752e-07, 1e-12);
  const FlowTimes contract = flow_times(FlowSchedule::contract, 10, 1.0);
  const double ends[] = {1.5119e-4, 5.3097e-4, 1.4849e-3, 3.8812e-3, 9.9005e-3,
                         0.025020,  0.063000,  0.158402,  0.398043,  1.0};
  for (int j = 0; j < 10; ++j) EXPECT_NEAR(contract.stretch(j, 1e4).to / ends[j], 1.0, 1e-4) << j;
  EXPECT_NEAR(contract.stretch(4, 1e-9).to, 0.5, 1e-9);  // no division by s
}

TEST(ExactFlow, ClosedFormHasTheValuesOfTheSpecification) {
  const Toy toy;
  const Vector3 end = vector3(1.244227192944, -1.993053531714, 0.528424729902);
  expect_near(toy.flow(&Toy::closed_form, FlowSchedule::uniform, 1, 1), end, kExact);
  expect_near(toy.flow(&Toy::closed_form, FlowSchedule::uniform, 17, 1), end, kExact);
  expect_near(toy.flow(&Toy::closed_form, FlowSchedule::contract, 10, 1), end, kExact);
  const Vector3 half_way = toy.moved(toy.closed_form({0.0, 0.3}));
  expect_near(box_plus(toy.m0, half_way), vector3(1.262971694846, -2.062605499297, 0.535675892480), kExact);

  const FlowStep step = toy.closed_form({0.0, 1.0});
  CloudMap map;
  map.clear();
  map.append(step, toy.k, toy.h);
  expect_near(map.a,
              matrix3({0.903901695101, 0.128131073198, -0.240245762247, 0.356575289229, 0.524566281028,
                       0.891438223073, -0.037174870579, 0.049566494106, 0.907062823552}),
              kExact);
  EXPECT_NEAR(std::exp(log_determinant(step, toy.s)), 0.335530799681, kExact);
  expect_near(sandwich(map.a, toy.p), toy.covariance, kExact);
  expect_near(box_plus(toy.m0, map.b), toy.mean, kExact);
}

/// C(lambda) x + c(lambda) of the published study, as a matrix, in absolute coordinates with m0 = x(0).
Vector3 published_velocity(const Toy& toy, double lambda, const Vector3& x) {
  Matrix3 c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) c(i, j) = -0.5 * toy.k[i] * toy.h[j] / (lambda * toy.s + toy.r);
  const Vector3 gain = plus(Vector3{}, 3.0 / toy.r, toy.k);
  Vector3 inner = plus(gain, lambda, multiply(c, gain));
  inner = plus(inner, 1.0, multiply(c, toy.m0));
  const Vector3 offset = plus(inner, 2.0 * lambda, multiply(c, inner));
  return plus(multiply(c, x), 1.0, offset);
}

TEST(ExactFlow, ClosedFormSolvesThePublishedOrdinaryDifferentialEquation) {
  const Toy toy;
  // Runge-Kutta of fourth order, in 4000 steps: its error is some 1e-11 here.
  constexpr int steps = 4000;
  Vector3 x = toy.x0;
  for (int j = 0; j < steps; ++j) {
    const double h = 1.0 / steps, at = j * h;
    const Vector3 k1 = published_velocity(toy, at, x);
    const Vector3 k2 = published_velocity(toy, at + h / 2, plus(x, h / 2, k1));
    const Vector3 k3 = published_velocity(toy, at + h / 2, plus(x, h / 2, k2));
    const Vector3 k4 = published_velocity(toy, at + h, plus(x, h, k3));
    x = plus(x, h / 6, plus(plus(plus(k1, 2.0, k2), 2.0, k3), 1.0, k4));
  }
  expect_near(x, toy.flow(&Toy::closed_form, FlowSchedule::uniform, 10, 1), 1e-10);
}

TEST(ExactFlow, EulerHasTheValuesOfTheSpecification) {
  const Toy toy;
  expect_near(toy.flow(&Toy::euler, FlowSchedule::uniform, 10, 1),
              vector3(1.246282281079, -2.000678990320, 0.529219724523), kExact);
  expect_near(toy.flow(&Toy::euler, FlowSchedule::exponential, 29, 1.2),
              vector3(1.245000977011, -1.995924677855, 0.528724062159), kExact);
  expect_near(toy.flow(&Toy::euler, FlowSchedule::exponential, 10, 1.3),
              vector3(1.245750099844, -1.998704317842, 0.529013854413), kExact);
  // uniform, 1000 steps: more than a configuration may ask for
  Vector3 e = box_minus(toy.x0, toy.m0);
  for (int j = 0; j < 1000; ++j) e = flowed(e, toy.euler({j / 1000.0, (j + 1) / 1000.0}), toy.k, toy.h);
  expect_near(box_plus(toy.m0, e), vector3(1.244246336946, -1.993124566035, 0.528432135608), kExact);
}

TEST(ExactFlow, EulerHasThePublishedVelocityAtTheStepsEnd) {
  const Toy toy;
  const Vector3 moved_by = plus(toy.moved(toy.euler({0.2, 0.3})), -1.0, box_minus(toy.x0, toy.m0));
  expect_near(moved_by, plus(Vector3{}, 0.1, published_velocity(toy, 0.3, toy.x0)), 1e-13);
}

/// Fraction of the innovation applied, and contraction over the exact one, of the table in 7.6.
TEST(ExactFlow, EulerLagsBehindAsTheSpecificationSays) {
  const struct {
    FlowTimes times;
    double stiffness, contraction, tolerance, applied;
  } rows[] = {{flow_times(FlowSchedule::uniform, 10, 1), 1e4, 17.6, 0.05, 0.824},
              {flow_times(FlowSchedule::exponential, 29, 1.2), 1e2, 1.10, 0.005, 0.976},
              {flow_times(FlowSchedule::contract, 10, 1), 1e6, 9.2, 0.05, 0.993}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.stiffness);
    double width = 1.0, mean = 0.0;  // P = H = 1, so s = stiffness r
    const double r = 1.0 / row.stiffness;
    for (int j = 0; j < row.times.steps; ++j) {
      const FlowStep f = euler_step(row.times.stretch(j, row.stiffness), 1.0, r, 1.0);
      width *= 1.0 - f.pull;
      mean += f.shift - f.pull * mean;
    }
    EXPECT_NEAR(width / std::sqrt(r / (1.0 + r)), row.contraction, row.tolerance);
    EXPECT_NEAR(mean, row.applied, 0.0005);
  }
}

TEST(ExactFlow, GromovHasTheValuesOfTheSpecification) {
  const Toy toy;
  const FlowStep f = toy.gromov({0.0, 1.0});
  const Vector3 e = plus(toy.moved(f), 0.5 * f.noise, toy.k);
  expect_near(box_plus(toy.m0, e), vector3(1.232620320856, -1.949985927385, 0.523934703068), kExact);
}

/// Mean and covariance of a cloud of the prior, moved by the float32 map of a flow in `steps` steps.
PoseGaussian moved_cloud(const Toy& toy, int steps, std::uint32_t count, Toy::Form form) {
  CloudMap map;
  map.clear();
  const FlowTimes times = flow_times(FlowSchedule::uniform, steps, 1);
  for (int j = 0; j < steps; ++j) map.append((toy.*form)(times.stretch(j, toy.s / toy.r)), toy.k, toy.h);
  CloudMove move;
  finish_cloud_move(map, toy.m0, move);
  const Cholesky3 root = cholesky(toy.p);
  PoseGaussian sum;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Normals n = normals(philox(i, 0, Stream::gaussian_start, 0, 7));
    const Vector3 x = box_plus(toy.m0, multiply(root.l, vector3(n.n[0], n.n[1], n.n[2])));
    float p[3] = {static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])};
    move_one(p[0], p[1], p[2], move, move.noisy, i, 0, 7);
    const Vector3 d = box_minus(vector3(p[0], p[1], p[2]), toy.mean);
    sum.mean = plus(sum.mean, 1.0 / count, d);
    sum.covariance = plus_outer(sum.covariance, 1.0 / count, d);
  }
  sum.covariance = plus_outer(sum.covariance, -1.0, sum.mean);
  return sum;
}

// Five standard errors of 400,000 samples: 1.5e-3 of a mean (standard deviation 0.19), 4e-4 of a covariance.
TEST(ExactFlow, CloudsBecomeTheKalmanPosterior) {
  const Toy toy;
  for (const Toy::Form form : {&Toy::closed_form, &Toy::gromov}) {
    for (const int steps : {1, 5}) {
      const PoseGaussian s = moved_cloud(toy, steps, 400'000, form);
      expect_near(s.mean, Vector3{}, 1.5e-3);
      expect_near(s.covariance, toy.covariance, 4e-4);
    }
  }
}

TEST(ExactFlow, NoiseOfAllStepsTogetherMakesTheKalmanCovariance) {
  const Toy toy;
  for (const int steps : {1, 6}) {
    CloudMap map;
    map.clear();
    for (int j = 0; j < steps; ++j)
      map.append(toy.gromov({1.0 * j / steps, (j + 1.0) / steps}), toy.k, toy.h);
    const Matrix3 root = semidefinite_root(map.noise);
    Matrix3 spread = sandwich(map.a, toy.p);
    const Matrix3 noise = multiply_transposed(root, root);
    for (int i = 0; i < 9; ++i) spread.m[i] += noise.m[i];
    expect_near(spread, toy.covariance, kExact);
    EXPECT_LT(root(2, 2), 1e-6);  // all steps push along the same k here
  }
}

FlowRules toy_rules(const Toy& toy, int steps, bool euler) {
  FlowRules rules;
  rules.times = flow_times(FlowSchedule::uniform, steps, 1);
  rules.euler = euler;
  rules.noise = {0.0, toy.r};
  return rules;
}

TEST(ParticleFlow, LocalFlowEqualsTheCommonOneWherePsiIsLinear) {
  const Toy toy;
  const FlowRules rules = toy_rules(toy, 10, false);
  ParticleFlow flow;
  flow.begin_local(toy.m0, toy.p, toy.x0, rules);
  while (!flow.done()) flow.take(toy.at(flow.at()), rules, 1.0);
  expect_near(flow.pose(), vector3(1.244227192944, -1.993053531714, 0.528424729902), kExact);
}

// Whatever was drawn, and however long the steps: the weight is the evidence of the measurement.
TEST(ParticleFlow, WeightsOfALinearProblemAreAllTheEvidence) {
  const Toy toy;
  for (const auto& [steps, drawn] : {std::pair{1, vector3(0.3, -0.2, 0.05)},
                                     {10, vector3(-0.1, 0.4, 0.02)},
                                     {29, vector3(0.0, 0.0, 0.0)}}) {
    const FlowRules rules = toy_rules(toy, steps, false);
    ParticleFlow flow;
    flow.begin_weighted({toy.m0, toy.p, drawn}, rules);
    while (!flow.done()) flow.take(toy.at(flow.at()), rules, 1.0);
    EXPECT_NEAR(flow.log_weight(), 0.2775324206410407, 1e-10);
  }
}

TEST(ParticleFlow, AProposalHasTheDensityThatItIsWeighedBy) {
  FlowRules rules;
  rules.pfpf_sigma_xy = 0.005f, rules.pfpf_sigma_theta = 0.01f;
  const MotionNoise u{0.3, 0.2, -0.1, vector3(0.02 * 0.02, 0.03 * 0.03, 0.04 * 0.04)};
  const Vector3 pose = vector3(4.0, 3.0, 1.0);
  const Matrix3 expected = propose(pose, u, rules, 0, {1, 0}).covariance;
  Vector3 mean;
  Matrix3 covariance;
  constexpr std::uint32_t count = 100'000;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vector3 d = propose(pose, u, rules, i, {1, 0}).drawn;
    mean = plus(mean, 1.0 / count, d);
    covariance = plus_outer(covariance, 1.0 / count, d);
  }
  // Five standard errors: 5 sigma / sqrt(n) of a mean, 5 sqrt(2 / n) sigma^2 of a variance; sigma <= 0.05.
  expect_near(mean, Vector3{}, 5 * 0.05 / std::sqrt(1.0 * count));
  expect_near(covariance, expected, 5 * std::sqrt(2.0 / count) * 0.05 * 0.05);
}

TEST(MeanUpdate, TheFlowStartsFromAFloat) {
  for (double x : {51.123456789, -6.7777777777, 1e-7, 0.0, 3.14159265358979, -2047.00000123}) {
    volatile float nearest = static_cast<float>(x);
    EXPECT_EQ(in_float32(x), static_cast<double>(nearest));
    EXPECT_EQ(in_float32(vector3(x, 2 * x, 4 * x))[2], 4 * static_cast<double>(nearest));
  }
}

TEST(PoseAlgebra, ACovarianceIsNeverSingular) {
  for (const Matrix3& bad :
       {Matrix3{}, matrix3({1, 1, 0, 1, 1, 0, 0, 0, 0}), matrix3({1, 0, 0, 0, -1e-9, 0, 0, 0, 1}),
        matrix3({4, 2, 2, 2, 1, 1, 2, 1, 1})}) {
    const Matrix3 p = proper_covariance(bad);
    EXPECT_TRUE(cholesky(p).ok);
    EXPECT_NEAR(p(0, 0), bad(0, 0), 1e-8);
  }
}

}  // namespace
}  // namespace parloc
