#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <unordered_set>
#include <utility>
#include <vector>

#include <ceres/ceres.h>

#include "deepslam/graph/graph_model.h"
#include "deepslam/graph/information.h"
#include "deepslam/graph/residuals.h"
#include "deepslam/graph/subgraph_edges.h"

namespace deepslam::graph {
namespace {

constexpr int kPoseSize = 7;           // quaternion and translation
constexpr std::size_t kPlaneSize = 4;  // normal and d
constexpr double kRoundFactor = 4.0;   // widths of successive rounds
// Relative change of the cost; later rounds begin anew from there.
constexpr double kCoarseTolerance = 1e-4;
constexpr double kFineTolerance = 1e-9;      // of the last round, whose result is kept
constexpr int kMaxConjugateGradients = 500;  // steps; some twenty are usual

// One contiguous block, since Ceres orders parameter blocks by address.
class Parameters {
 public:
  explicit Parameters(const GraphModel& model)
      : ground_(model.world_from_node.size() * kPoseSize),
        values_(ground_ + kPlaneSize * (1 + model.walls.size())) {
    for (std::size_t k = 0; k < model.world_from_node.size(); ++k) {
      double* pose = Pose(static_cast<int>(k));
      Eigen::Map<Eigen::Vector4d> rotation(pose);
      Eigen::Map<Eigen::Vector3d> translation_m(pose + 4);
      rotation = model.world_from_node[k].rotation.coeffs();
      translation_m = model.world_from_node[k].translation_m;
    }
    SetPlane(model.plane.value_or(deepslam::Plane{}), Plane());
    for (std::size_t k = 0; k < model.walls.size(); ++k)
      SetPlane(model.walls[k], Wall(static_cast<int>(k)));
  }

  double* Pose(int node) { return values_.data() + static_cast<std::size_t>(node) * kPoseSize; }
  double* Plane() { return values_.data() + ground_; }
  double* Wall(int wall) { return Plane() + kPlaneSize * (1 + static_cast<std::size_t>(wall)); }
  [[nodiscard]] bool AllFinite() const {
    return std::all_of(values_.begin(), values_.end(), [](double v) { return std::isfinite(v); });
  }

  void Store(GraphModel& model) {
    for (std::size_t k = 0; k < model.world_from_node.size(); ++k) {
      const double* pose = Pose(static_cast<int>(k));
      const Eigen::Quaterniond rotation(Eigen::Map<const Eigen::Vector4d>{pose});
      model.world_from_node[k] = {rotation.normalized(),
                                  Eigen::Map<const Eigen::Vector3d>(pose + 4)};
    }
    for (std::size_t k = 0; k < model.walls.size(); ++k)
      model.walls[k] = PlaneAt(Wall(static_cast<int>(k)));
    if (model.plane) model.plane = PlaneAt(Plane());
  }

 private:
  static void SetPlane(const deepslam::Plane& plane, double* values) {
    Eigen::Map<Eigen::Vector3d> normal(values);
    normal = plane.normal;
    values[3] = plane.d_m;
  }
  static deepslam::Plane PlaneAt(const double* values) {
    return {Eigen::Map<const Eigen::Vector3d>(values).normalized(), values[3]};
  }

  std::size_t ground_;  // where the ground's plane begins; walls follow
  std::vector<double> values_;
};

const std::string& LossName(EdgeKind kind, const GraphOptions& options) {
  switch (kind) {
    case EdgeKind::kObject:
      return options.object_loss;
    case EdgeKind::kLoop:
      return options.loop_loss;
    case EdgeKind::kOdometry:
      break;
  }
  return options.odometry_loss;
}

// Of its kind, as often as it was measured.
double Lambda(const PoseEdge& edge) {
  return edge.weight * (edge.kind == EdgeKind::kObject ? 1.0 : GraphOptions::kLambdaOdometry);
}

// lambda * loss(r^T r); the width is in deviations, whatever lambda.
ceres::LossFunction* Loss(const std::string& name, double width, double lambda) {
  ceres::LossFunction* loss = nullptr;
  if (name == "huber") loss = new ceres::HuberLoss(width);
  if (name == "cauchy") loss = new ceres::CauchyLoss(width);
  return new ceres::ScaledLoss(loss, lambda, ceres::TAKE_OWNERSHIP);
}

PoseResidual Residual(const PoseEdge& edge) {
  return {edge.a_from_b.Inverse(), SqrtInformation<6>(edge.information)};
}

GroundResidual Residual(const GroundEdge& edge) {
  return {GroundTangentBasis(edge.plane_camera.normal),
          edge.plane_camera.d_m,
          SqrtInformation<3>(edge.information)};
}

// Of the ground or of a wall: one plane, seen from one node.
ceres::CostFunction* PlaneTerm(const GroundEdge& edge) {
  return new ceres::AutoDiffCostFunction<GroundResidual, 3, kPoseSize, 4>(
      new GroundResidual(Residual(edge)));
}

using Residuals = std::vector<ceres::ResidualBlockId>;  // in the order of what they are of

Residuals AddPoseEdges(const GraphModel& model,
                       const GraphOptions& options,
                       double width,
                       Parameters& parameters,
                       ceres::Problem& problem) {
  Residuals residuals;
  for (const PoseEdge& edge : model.pose_edges) {
    residuals.push_back(problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<PoseResidual, 6, kPoseSize, kPoseSize>(
            new PoseResidual(Residual(edge))),
        Loss(LossName(edge.kind, options), width, Lambda(edge)),
        parameters.Pose(edge.a),
        parameters.Pose(edge.b)));
  }
  return residuals;
}

Residuals AddGroundEdges(const GraphModel& model,
                         const GraphOptions& options,
                         double width,
                         Parameters& parameters,
                         ceres::Problem& problem) {
  Residuals residuals;
  if (!model.plane) return residuals;
  const auto add = [&](ceres::CostFunction* term, ceres::LossFunction* loss, int node) {
    residuals.push_back(
        problem.AddResidualBlock(term, loss, parameters.Pose(node), parameters.Plane()));
  };
  for (const GroundEdge& edge : model.ground_edges) {
    add(PlaneTerm(edge), Loss(options.ground_loss, width, GraphOptions::kLambdaGround), edge.node);
  }
  for (const int node : model.upright) {
    add(new ceres::AutoDiffCostFunction<UprightResidual, 3, kPoseSize, 4>(new UprightResidual()),
        Loss("none", width, GraphOptions::kLambdaUpright),
        node);
  }
  return residuals;
}

Residuals AddWallEdges(const GraphModel& model,
                       const GraphOptions& options,
                       double width,
                       Parameters& parameters,
                       ceres::Problem& problem) {
  Residuals residuals;
  for (const WallEdge& edge : model.wall_edges) {
    residuals.push_back(
        problem.AddResidualBlock(PlaneTerm(edge.view),
                                 Loss(options.ground_loss, width, GraphOptions::kLambdaGround),
                                 parameters.Pose(edge.view.node),
                                 parameters.Wall(edge.wall)));
  }
  return residuals;
}

void AddPlane(double* plane, ceres::Problem& problem) {
  problem.AddParameterBlock(
      plane,
      4,
      new ceres::ProductManifold<ceres::SphereManifold<3>, ceres::EuclideanManifold<1>>());
}

void AddVariables(const GraphModel& model, Parameters& parameters, ceres::Problem& problem) {
  for (std::size_t k = 0; k < model.world_from_node.size(); ++k) {
    problem.AddParameterBlock(
        parameters.Pose(static_cast<int>(k)),
        kPoseSize,
        new ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<3>>());
  }
  // Gauge: see object_graph.h.
  problem.SetParameterBlockConstant(parameters.Pose(0));
  for (std::size_t k = 0; k < model.walls.size(); ++k)
    AddPlane(parameters.Wall(static_cast<int>(k)), problem);
  if (!model.plane) return;
  AddPlane(parameters.Plane(), problem);
  if (model.ground_edges.empty()) problem.SetParameterBlockConstant(parameters.Plane());
}

// The factor of a path that goes round and round grows with the square of the rounds, the edges
// that carry it do not: conjugate gradients preconditioned by the factor of those alone.
void UseConjugateGradients(const GraphModel& model,
                           const Residuals& of_pose_edges,
                           const Residuals& of_planes,
                           ceres::Solver::Options& solver) {
  std::unordered_set<ceres::ResidualBlockId> subgraph(of_planes.begin(), of_planes.end());
  for (const std::size_t edge : SubgraphEdges(model)) subgraph.insert(of_pose_edges[edge]);
  solver.linear_solver_type = ceres::CGNR;
  solver.preconditioner_type = ceres::SUBSET;
  solver.residual_blocks_for_subset_preconditioner = std::move(subgraph);
  solver.max_linear_solver_iterations = kMaxConjugateGradients;
}

ceres::Solver::Summary SolveRound(const GraphModel& model,
                                  const GraphOptions& options,
                                  double width,
                                  double tolerance,
                                  Parameters& parameters) {
  ceres::Problem problem;
  AddVariables(model, parameters, problem);
  const Residuals of_pose_edges = AddPoseEdges(model, options, width, parameters, problem);
  Residuals of_planes = AddGroundEdges(model, options, width, parameters, problem);
  const Residuals of_walls = AddWallEdges(model, options, width, parameters, problem);
  of_planes.insert(of_planes.end(), of_walls.begin(), of_walls.end());
  ceres::Solver::Options solver;
  solver.minimizer_type = ceres::TRUST_REGION;
  solver.trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  solver.num_threads = 1;  // byte-equal results; see object_graph.h
  solver.max_num_iterations = options.max_iterations;
  solver.max_solver_time_in_seconds = 1e9;
  solver.function_tolerance = tolerance;
  solver.gradient_tolerance = 1e-12;
  solver.parameter_tolerance = 1e-12;
  solver.logging_type = ceres::SILENT;
  if (model.num_keyframes() > options.max_direct_keyframes)
    UseConjugateGradients(model, of_pose_edges, of_planes, solver);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  return summary;
}

enum Term { kIo, kIj, kPi, kPo, kLoopTerm, kWall, kNumTerms };

// That of walls is there where there are any.
std::vector<EnergyTerm> EmptyTerms(const GraphModel& model) {
  std::vector<EnergyTerm> terms(model.wall_edges.empty() ? kWall : kNumTerms);
  const char* const names[kNumTerms] = {"r_io", "r_ij", "r_pi", "r_po", "loop", "r_pw"};
  for (std::size_t k = 0; k < terms.size(); ++k) terms[k].name = names[k];
  return terms;
}

template <typename Functor, int N>
double SquaredNorm(const Functor& functor, const double* a, const double* b) {
  Eigen::Matrix<double, N, 1> residual;
  functor(a, b, residual.data());
  return residual.squaredNorm();
}

// Energy per term at the parameters, without robust losses; and the number of edges.
std::vector<EnergyTerm> Energies(const GraphModel& model, Parameters& parameters) {
  std::vector<EnergyTerm> terms = EmptyTerms(model);
  const auto add = [&terms](Term term, double energy) {
    terms[term].after += energy;
    ++terms[term].num_edges;
  };
  for (const PoseEdge& edge : model.pose_edges) {
    const Term term = edge.kind == EdgeKind::kObject ? kIo
                      : edge.kind == EdgeKind::kLoop ? kLoopTerm
                                                     : kIj;
    add(term,
        Lambda(edge) * SquaredNorm<PoseResidual, 6>(
                           Residual(edge), parameters.Pose(edge.a), parameters.Pose(edge.b)));
  }
  for (const GroundEdge& edge : model.ground_edges) {
    add(kPi,
        GraphOptions::kLambdaGround * SquaredNorm<GroundResidual, 3>(Residual(edge),
                                                                     parameters.Pose(edge.node),
                                                                     parameters.Plane()));
  }
  for (const WallEdge& edge : model.wall_edges) {
    add(kWall,
        GraphOptions::kLambdaGround *
            SquaredNorm<GroundResidual, 3>(
                Residual(edge.view), parameters.Pose(edge.view.node), parameters.Wall(edge.wall)));
  }
  for (const int node : model.upright) {
    add(kPo,
        GraphOptions::kLambdaUpright *
            SquaredNorm<UprightResidual, 3>({}, parameters.Pose(node), parameters.Plane()));
  }
  return terms;
}

bool AnyRobustLoss(const GraphOptions& options) {
  return options.object_loss != "none" || options.odometry_loss != "none" ||
         options.loop_loss != "none" || options.ground_loss != "none";
}

}  // namespace

OptimizationSummary SolveGraph(GraphModel& model, const GraphOptions& options) {
  OptimizationSummary summary;
  summary.ground_observed = model.plane.has_value() ? 1.0 : 0.0;
  Parameters parameters(model);
  summary.terms = Energies(model, parameters);
  for (EnergyTerm& term : summary.terms) term.before = term.after;
  if (model.world_from_node.size() < 2) {
    summary.converged = true;
    summary.message = "nothing to optimise";
    return summary;
  }

  const int rounds = AnyRobustLoss(options) ? std::max(1, options.loss_rounds) : 1;
  for (int round = 0; round < rounds; ++round) {
    const bool last = round + 1 == rounds;
    const double width = GraphOptions::kLossWidth * std::pow(kRoundFactor, rounds - 1 - round);
    const ceres::Solver::Summary solved =
        SolveRound(model, options, width, last ? kFineTolerance : kCoarseTolerance, parameters);
    summary.num_iterations += std::max(0, static_cast<int>(solved.iterations.size()) - 1);
    summary.converged = solved.termination_type == ceres::CONVERGENCE;
    if (!solved.IsSolutionUsable() || !parameters.AllFinite()) {
      summary.converged = false;
      summary.message = "the solver failed, poses are left as they were: " + solved.message;
      return summary;
    }
  }
  summary.message = summary.converged ? "converged" : "stopped at max_iterations";
  const std::vector<EnergyTerm> after = Energies(model, parameters);
  for (std::size_t k = 0; k < after.size(); ++k) summary.terms[k].after = after[k].after;
  parameters.Store(model);
  return summary;
}

}  // namespace deepslam::graph
