#include "deepslam/refine/refine_latents.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include <ceres/ceres.h>

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::refine {
namespace {

// Against Dice, which lies in [0, 1]: L(z) of the header.
constexpr double kCrossEntropyWeight = 20;
constexpr double kSolidWeight = 3;  // known free voxels are many more than solid ones

bool IsSurface(Evidence evidence) {
  return evidence == Evidence::kFaint || evidence == Evidence::kSolid;
}

struct KnownVoxels {
  std::vector<std::size_t> free;
  std::vector<std::size_t> solid;
};

// Calls use(index) for a voxel and those round it.
template <typename Use>
void ForAround(std::size_t index, const Use& use) {
  const int i = static_cast<int>(index / (kGridSize * kGridSize));
  const int j = static_cast<int>(index / kGridSize % kGridSize);
  const int k = static_cast<int>(index % kGridSize);
  for (int a = std::max(0, i - 1); a <= std::min(kGridSize - 1, i + 1); ++a) {
    for (int b = std::max(0, j - 1); b <= std::min(kGridSize - 1, j + 1); ++b) {
      for (int c = std::max(0, k - 1); c <= std::min(kGridSize - 1, k + 1); ++c)
        use(VoxelGrid::Index(a, b, c));
    }
  }
}

KnownVoxels KnownOf(std::span<const Evidence> evidence) {
  KnownVoxels known;
  std::vector<bool> near(evidence.size(), false);
  for (std::size_t n = 0; n < evidence.size(); ++n) {
    if (!IsSurface(evidence[n])) continue;
    known.solid.push_back(n);
    ForAround(n, [&](std::size_t m) { near[m] = true; });
  }
  for (std::size_t n = 0; n < evidence.size(); ++n) {
    if (evidence[n] == Evidence::kFree && !near[n]) known.free.push_back(n);
  }
  return known;
}

double Sigmoid(double logit) { return 1.0 / (1.0 + std::exp(-logit)); }
// log(1 + exp(x)).
double SoftPlus(double x) { return std::max(x, 0.0) + std::log1p(std::exp(-std::abs(x))); }

// For each solid voxel the one round it with the highest logit, the first of equals.
std::vector<std::size_t> Strongest(std::span<const float> logits,
                                   std::span<const std::size_t> solid) {
  std::vector<std::size_t> strongest;
  strongest.reserve(solid.size());
  for (const std::size_t n : solid) {
    std::size_t best = n;
    ForAround(n, [&](std::size_t m) {
      if (logits[m] > logits[best]) best = m;
    });
    strongest.push_back(best);
  }
  return strongest;
}

struct Loss {
  double value = 0;
  std::vector<float> by_logits;  // of all voxels; empty unless asked for
};

// 20 BCE + 1 - Dice.
Loss Disagreement(std::span<const float> logits, const KnownVoxels& known, bool with_gradient) {
  const std::vector<std::size_t> strongest = Strongest(logits, known.solid);
  double cross_entropy = 0;
  double filled = 0;  // sum of shares where there is nothing
  double met = 0;     // and where there is something
  for (const std::size_t n : known.free) {
    cross_entropy += SoftPlus(logits[n]);
    filled += Sigmoid(logits[n]);
  }
  for (const std::size_t n : strongest) {
    cross_entropy += kSolidWeight * SoftPlus(-logits[n]);
    met += Sigmoid(logits[n]);
  }
  const auto count = static_cast<double>(known.free.size() + known.solid.size());
  const auto num_solid = static_cast<double>(known.solid.size());
  const double all = filled + met + num_solid;
  Loss loss;
  loss.value = kCrossEntropyWeight * cross_entropy / count + 1 - 2 * met / all;
  if (!with_gradient) return loss;
  loss.by_logits.assign(logits.size(), 0.0F);
  const double entropy_weight = kCrossEntropyWeight / count;
  for (const std::size_t n : known.free) {
    const double share = Sigmoid(logits[n]);
    loss.by_logits[n] +=
        static_cast<float>(entropy_weight * share + 2 * met / (all * all) * share * (1 - share));
  }
  for (const std::size_t n : strongest) {
    const double share = Sigmoid(logits[n]);
    loss.by_logits[n] -=
        static_cast<float>(entropy_weight * kSolidWeight * (1 - share) +
                           2 * (filled + num_solid) / (all * all) * share * (1 - share));
  }
  return loss;
}

// L as a function of the way from the start, in units of the start's size.
class LatentLoss final : public ceres::FirstOrderFunction {
 public:
  LatentLoss(std::span<const float> start,
             KnownVoxels known,
             const Decoder& decoder,
             const RefineOptions& options)
      : start_(start), known_(std::move(known)), decoder_(decoder), options_(options) {
    double sum = 0;
    for (const float latent : start) sum += static_cast<double>(latent) * latent;
    unit_ = std::max(1e-3, std::sqrt(sum / static_cast<double>(start.size())));
  }

  [[nodiscard]] int NumParameters() const override { return static_cast<int>(start_.size()); }

  [[nodiscard]] std::vector<float> LatentsAt(const double* way) const {
    std::vector<float> latents(start_.size());
    for (std::size_t n = 0; n < latents.size(); ++n)
      latents[n] = static_cast<float>(start_[n] + unit_ * way[n]);
    return latents;
  }

  // False stops the solver; error() then says why.
  bool Evaluate(const double* way, double* cost, double* gradient) const override {
    if (++num_evaluations_ > options_.max_evaluations) return false;
    const std::vector<float> latents = LatentsAt(way);
    const Result<std::vector<float>> logits = decoder_.logits(latents);
    if (!logits.ok()) return Stop(logits.error());
    const Loss loss = Disagreement(*logits, known_, gradient != nullptr);
    const auto count = static_cast<double>(start_.size());
    double prior = 0;
    for (std::size_t n = 0; n < start_.size(); ++n) prior += way[n] * way[n] / count;
    *cost = loss.value + options_.prior_weight * prior;
    if (!std::isfinite(*cost)) return false;
    if (best_way_.empty()) initial_cost_ = *cost;
    if (best_way_.empty() || *cost < best_cost_) {
      best_cost_ = *cost;
      best_way_.assign(way, way + start_.size());
    }
    if (gradient == nullptr) return true;
    const Result<std::vector<float>> by_latents = decoder_.latent_gradient(latents, loss.by_logits);
    if (!by_latents.ok()) return Stop(by_latents.error());
    for (std::size_t n = 0; n < start_.size(); ++n)
      gradient[n] = unit_ * (*by_latents)[n] + 2 * options_.prior_weight * way[n] / count;
    return true;
  }

  [[nodiscard]] const std::optional<Error>& error() const { return error_; }
  [[nodiscard]] const std::vector<double>& best_way() const { return best_way_; }
  [[nodiscard]] double best_cost() const { return best_cost_; }
  [[nodiscard]] double initial_cost() const { return initial_cost_; }

 private:
  bool Stop(const Error& error) const {
    error_ = error;
    return false;
  }

  std::span<const float> start_;
  KnownVoxels known_;
  const Decoder& decoder_;
  const RefineOptions& options_;
  double unit_ = 1;
  // The solver's seam is const; what it has seen is kept all the same, since it may stop anywhere.
  mutable int num_evaluations_ = 0;
  mutable std::vector<double> best_way_;
  mutable double best_cost_ = 0;
  mutable double initial_cost_ = 0;
  mutable std::optional<Error> error_;
};

Status CheckInput(std::span<const float> start,
                  std::span<const Evidence> evidence,
                  const RefineOptions& options) {
  if (start.empty() ||
      !std::all_of(start.begin(), start.end(), [](float v) { return std::isfinite(v); }))
    return InvalidInput("the latents to start from must be finite numbers");
  const auto num_solid = std::count_if(evidence.begin(), evidence.end(), IsSurface);
  if (num_solid < options.min_voxels)
    return InvalidInput("the depth shows " + std::to_string(num_solid) +
                        " voxels of the object, fewer than refine.min_voxels");
  return Ok();
}

}  // namespace

void Describe(OptionsVisitor& visitor, RefineOptions& options) {
  visitor.Field("enabled",
                options.enabled,
                "let the networks' best shape follow all depth of its object; it competes with the "
                "others");
  visitor.Field("complete",
                options.complete,
                "let measured depth complete the best whole model; it competes with the others");
  visitor.Field("follow_level_face",
                options.follow_level_face,
                "voxels of a completed model follow the object's level face, as a table's top");
  visitor.Field(
      "pose",
      options.pose,
      "refine the winner's scale and pose over all views at once, where agreement improves");
}

Result<RefinedLatents> RefineLatents(std::span<const float> start,
                                     std::span<const Evidence> evidence,
                                     const Decoder& decoder,
                                     const RefineOptions& options) {
  if (Status status = CheckInput(start, evidence, options); !status.ok()) return status.error();
  // The problem owns its function.
  auto* const loss = new LatentLoss(start, KnownOf(evidence), decoder, options);
  const ceres::GradientProblem problem(loss);
  std::vector<double> way(start.size(), 0.0);
  ceres::GradientProblemSolver::Options solver;
  solver.line_search_direction_type = ceres::LBFGS;
  solver.max_num_iterations = options.max_evaluations;
  solver.function_tolerance = 1e-4;
  solver.logging_type = ceres::SILENT;
  ceres::GradientProblemSolver::Summary summary;
  ceres::Solve(solver, problem, way.data(), &summary);
  if (loss->error()) return *loss->error();
  if (loss->best_way().empty()) return Failed("the loss of the latents is not finite");
  return RefinedLatents{
      loss->LatentsAt(loss->best_way().data()), loss->initial_cost(), loss->best_cost()};
}

}  // namespace deepslam::refine
