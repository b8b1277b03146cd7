#include "deepslam/alignment/frame_alignment.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "deepslam/alignment/alignment_levels.h"
#include "deepslam/alignment/place_judgement.h"
#include "deepslam/alignment/point_alignment.h"
#include "deepslam/alignment/reference_pixels.h"
#include "deepslam/core/check.h"

namespace deepslam::alignment {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;
// Scale of the first step in standard deviations of the noise: far off, every residual must pull.
constexpr float kFirstScale = 12.0F;
constexpr float kFirstPhotometricScale = 25.0F;
// ... halved where the start is near: within a few pixels of the levels that are left.
constexpr float kNearScale = 6.0F;
constexpr float kNearPhotometricScale = 12.0F;
constexpr std::size_t kNearLevels = 2;
// ... and the overlap there is what it will be, but for this share.
constexpr double kNearOverlap = 0.75;
constexpr float kMinPhotometricScale = 3.0F;  // grey levels: the noise of the camera itself
// Keeps directions that nothing constrains where the start put them.
constexpr StartSigma kPrior;
// The end of a descent. Convergence: what is left to go moves points at kConvergedDistanceM by less
// than this share of a pixel of the level; it is judged by every so many batches of points.
struct DescentEnd {
  double converged_px;
  int judged_stride;
};
// Of what becomes an edge.
constexpr DescentEnd kMeasured{0.01, 1};
// Where a frame is only to be placed: ends lie towards the start, which edges would carry on.
constexpr DescentEnd kPlaced{0.05, 2};
constexpr double kConvergedMiddlePx = 0.08;  // at levels that a finer one follows
constexpr double kConvergedFarPx = 0.04;     // at the coarsest level
constexpr double kConvergedDistanceM = 2.0;
// Steps that shrink by the same share each time are taken further at once, by at most this many
// times the last one.
constexpr double kMostFurther = 2;
// Descents closer together than this converge to the same place.
constexpr double kSamePlaceM = 0.005;
constexpr double kSamePlaceRad = 0.005;
// Depth errors are shared between neighbouring texels (see `correlation_length_px`): at a finest
// level of this width nothing is lost by taking every third row and column, and little at levels of
// that width that a finer one follows.
constexpr int kWideStride = 3;
constexpr int kWideLevel = 240;
constexpr int kWideMiddleLevel = 120;
// Places that compete at the coarsest level go by every second one.
constexpr int kCoarsestStride = 2;
constexpr int kWideCoarsestLevel = 60;
// Scale at which competing starts are compared.
constexpr float kJudgeScale = 3.0F;
// Share of the strongest direction's information below which depth leaves a direction open: along a
// wall, round the vertical on a floor.
constexpr double kOpenRatio = 0.02;
// ... and below which depth alone does not see it at all (rendered rooms, frame to frame: 8 cm off
// below 0.002, 0.1 cm above 0.004). On a bare wall what looks like structure are the steps of the
// sensor's disparity, which stay with the camera as it moves.
constexpr double kUnseenRatio = 0.003;
// Normals are off by about 0.1 rad (rms), and the squares of that look like structure: in every
// direction this share of the strongest one's information is theirs.
constexpr double kNoiseOfNormals = 0.01;
// Steps along an open direction, pixels of the coarsest level, to each side.
constexpr double kOpenStepPx = 0.75;
constexpr int kNumOpenSteps = 10;
// Images share no more than this of their variance, the camera's noise being what it is.
constexpr double kFullCorrelation = 0.999;
// A likelihood ratio of exp(6), 400 : 1, among some twenty places.
constexpr double kSureNats = 6;
// Fewer photometric residuals say nothing about the images' agreement.
constexpr int kMinPhotometricResiduals = 75;
// At the coarsest level most frames that are laid right have images as like as this and depth that
// agrees so well; wrong places along a tiled wall do not reach 0.8 of both.
constexpr double kSureCorrelation = 0.988;
constexpr double kSureAgreement = 0.95;
// Images that are as like as this are of the same place; then depth may be this much worse than
// asked, since the sensor's noise is known roughly only.
constexpr double kLikeImages = 0.9;
constexpr double kAgreementOfLikeImages = 0.6;

// Pixels of this level, of every stride-th row and column, that share one error.
double CorrelationFactor(const PyramidLevel& level, double length_at_640_px, int stride) {
  const double length_px = length_at_640_px * level.camera.width / (640.0 * stride);
  return std::max(1.0, length_px * length_px);
}

double CorrelationFactor(const SourcePoints& points, double length_at_640_px) {
  return CorrelationFactor(points.level(), length_at_640_px, points.choice().stride);
}

int Stride(const PyramidLevel& level) { return level.camera.width >= kWideLevel ? kWideStride : 1; }

int MiddleStride(const PyramidLevel& level) {
  return level.camera.width >= kWideMiddleLevel ? kWideStride : 1;
}

int CoarsestStride(const PyramidLevel& level) {
  return level.camera.width >= kWideCoarsestLevel ? kCoarsestStride : 1;
}

// The coarsest level's points, where nothing is near yet.
SourcePoints FarPoints(const PyramidLevel& level, int stride, const AlignmentOptions& options) {
  return SourcePoints(level, {stride, options.photometric, false});
}

SourcePoints NearPoints(const PyramidLevel& level, int stride, const AlignmentOptions& options) {
  return SourcePoints(level, {stride, options.photometric, true});
}

// Factors that turn a perturbation into metres: rotations count by their arc at the mean distance.
// Nothing where the Hessian says nothing.
std::optional<Vector6d> ArcScale(const Matrix6d& hessian) {
  const double translation = hessian.topLeftCorner<3, 3>().trace();
  const double rotation = hessian.bottomRightCorner<3, 3>().trace();
  if (!(translation > 0) || !(rotation > 0)) return std::nullopt;
  Vector6d scale = Vector6d::Ones();
  scale.tail<3>().setConstant(std::sqrt(rotation / translation));
  return scale;
}

// Eigenvalues, ascending, and directions of a Hessian of a perturbation in metres.
struct ArcSpectrum {
  Vector6d scale;
  Vector6d values;
  Matrix6d directions;

  // Back to a perturbation.
  [[nodiscard]] Vector6d Perturbation(const Vector6d& motion_m) const {
    return scale.cwiseInverse().cwiseProduct(motion_m);
  }
};

std::optional<ArcSpectrum> SpectrumByArc(const Matrix6d& hessian) {
  const std::optional<Vector6d> scale = ArcScale(hessian);
  if (!scale) return std::nullopt;
  const Eigen::DiagonalMatrix<double, 6> by_arc(scale->cwiseInverse());
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(by_arc * hessian * by_arc);
  return ArcSpectrum{*scale, eigen.eigenvalues(), eigen.eigenvectors()};
}

// An AlignmentSystem or a PlaceJudgement.
template <typename Compared>
bool SeesImages(const Compared& frames) {
  return frames.num_photometric >= kMinPhotometricResiduals;
}

double MeanDepthM(const PyramidLevel& level) {
  double sum = 0;
  int count = 0;
  for (const float z : level.depth_m) {
    if (!(z > 0)) continue;
    sum += static_cast<double>(z);
    ++count;
  }
  return count > 0 ? sum / count : 1.0;
}

// Directions of a left perturbation that a judged system does not see.
class Unseen {
 public:
  Unseen() = default;
  explicit Unseen(const Matrix6d& hessian) : spectrum_(SpectrumByArc(hessian)) {
    if (!spectrum_) return;
    while (num_ < 6 && spectrum_->values[num_] < kUnseenRatio * spectrum_->values[5]) ++num_;
  }
  [[nodiscard]] bool empty() const { return num_ == 0; }
  [[nodiscard]] Vector6d Part(const Vector6d& motion) const {
    if (empty()) return Vector6d::Zero();
    const auto basis = spectrum_->directions.leftCols(num_);
    const Vector6d motion_m = spectrum_->scale.cwiseProduct(motion);
    return spectrum_->Perturbation(basis * (basis.transpose() * motion_m));
  }

 private:
  std::optional<ArcSpectrum> spectrum_;
  int num_ = 0;
};

// The descent of one start through the levels.
struct Descent {
  Pose3 i_from_j;
  Pose3 start_i_from_j;
  AlignmentGates gates;
  AlignmentSystem system;  // at i_from_j, of the last level visited
  int stride = 1;          // ... of every stride-th row and column
  Unseen held;             // no steps along these
  double converged_px = kConvergedFarPx;
  std::optional<Matrix6d> structural;  // StructuralShare at the level's first step, for all of them
};

Descent DescentFrom(const Pose3& start_i_from_j) {
  Descent descent;
  descent.i_from_j = descent.start_i_from_j = start_i_from_j;
  return descent;
}

void TakeScales(const AlignmentSystem& system, bool near, AlignmentGates& gates) {
  // Scales only shrink: a step that makes things worse must not open the gates again.
  gates.geometric_scale = std::max(1.0F, std::min(gates.geometric_scale, system.geometric_scale));
  gates.photometric_scale =
      std::max(kMinPhotometricScale, std::min(gates.photometric_scale, system.photometric_scale));
  gates.gain = system.gain;
  gates.bias = system.bias;
  gates.falloff = near ? system.falloff : 0;
}

// Of a direction's information about a left perturbation, what depth tells and what its noise does
// not: the Hessian and its gradient are to be multiplied by it from the left.
Matrix6d StructuralShare(const Matrix6d& geometric) {
  const std::optional<ArcSpectrum> spectrum = SpectrumByArc(geometric);
  if (!spectrum) return Matrix6d::Identity();
  const double noise = kNoiseOfNormals * spectrum->values[5];
  const Vector6d values = spectrum->values.cwiseMax(0.0);
  const Vector6d share = values.array() / (values.array() + noise);
  const Matrix6d& directions = spectrum->directions;
  return spectrum->scale.asDiagonal() * directions * share.asDiagonal() * directions.transpose() *
         spectrum->scale.cwiseInverse().asDiagonal();
}

struct NormalEquations {
  Matrix6d hessian;
  Vector6d gradient;
};

// Near the place, depth and brightness each by the number of its independent measurements. Beside
// brightness depth counts for its structure alone, so that brightness decides in the directions
// that depth leaves weak, and depth in those where it is strong.
NormalEquations Balance(const SourcePoints& points,
                        const AlignmentOptions& options,
                        Descent& descent) {
  const AlignmentSystem& system = descent.system;
  const double of_depth = 1 / CorrelationFactor(points, options.correlation_length_px);
  const double of_brightness =
      1 / CorrelationFactor(points, options.photometric_correlation_length_px);
  const Matrix6d geometric = of_depth * (system.hessian - system.photometric_hessian);
  const Vector6d gradient = of_depth * (system.gradient - system.photometric_gradient);
  if (!SeesImages(system)) return {geometric, gradient};
  if (!descent.structural) descent.structural = StructuralShare(geometric);
  const Matrix6d& share = *descent.structural;
  const Matrix6d structural = share * geometric;
  return {0.5 * (structural + structural.transpose()) + of_brightness * system.photometric_hessian,
          share * gradient + of_brightness * system.photometric_gradient};
}

// Far off, where all that pulls is needed, every residual counts alike.
NormalEquations Measured(const SourcePoints& points,
                         const AlignmentOptions& options,
                         Descent& descent) {
  if (points.choice().near) return Balance(points, options, descent);
  const double share = 1 / CorrelationFactor(points, options.correlation_length_px);
  return {share * descent.system.hessian, share * descent.system.gradient};
}

Vector6d Step(const Descent& descent, const NormalEquations& measured) {
  Vector6d prior;
  prior.head<3>().setConstant(1 / (kPrior.translation_m * kPrior.translation_m));
  prior.tail<3>().setConstant(1 / (kPrior.rotation_rad * kPrior.rotation_rad));
  const Vector6d moved = T2v(descent.i_from_j * descent.start_i_from_j.Inverse());
  Matrix6d hessian = measured.hessian;
  hessian.diagonal() += prior;
  const Vector6d gradient = measured.gradient + prior.cwiseProduct(moved);
  const Vector6d step = -hessian.ldlt().solve(gradient);
  return step.allFinite() ? step : Vector6d::Zero();
}

// Anderson's mixing with a memory of one step: robust weights and new pairs make Gauss-Newton
// converge linearly, and by the last two steps it is seen where to.
class Mixing {
 public:
  Vector6d Move(const Vector6d& step) {
    Vector6d move = step;
    if (is_under_way_) {
      const Vector6d change = step - last_step_;
      const Vector6d change_m = InMetres(change);
      const double squared = change_m.squaredNorm();
      const double further = squared > 0 ? -InMetres(step).dot(change_m) / squared : 0;
      move += std::clamp(further, -kMostBack, kMostFurther) * (last_move_ + change);
    }
    is_under_way_ = true;
    last_step_ = step;
    last_move_ = move;
    return move;
  }

 private:
  static constexpr double kMostBack = 0.5;

  static Vector6d InMetres(const Vector6d& step) {
    Vector6d metres = step;
    metres.tail<3>() *= kConvergedDistanceM;
    return metres;
  }

  bool is_under_way_ = false;
  Vector6d last_step_ = Vector6d::Zero();
  Vector6d last_move_ = Vector6d::Zero();
};

// What is left to go behind a step, as steps shrink by about the same share each time.
class WayLeft {
 public:
  // In pixels, at kConvergedDistanceM; at most the step itself, and that before two are known.
  double Behind(const Vector6d& step, double focal_px) {
    const double step_px =
        focal_px * std::max(step.head<3>().norm() / kConvergedDistanceM, step.tail<3>().norm());
    const double share = last_px_ > 0 ? std::min(step_px / last_px_, kMostShare) : kMostShare;
    last_px_ = step_px;
    return step_px * share / (1 - share);
  }

 private:
  static constexpr double kMostShare = 0.5;
  double last_px_ = 0;
};

bool SamePlace(const Pose3& a, const Pose3& b) {
  const Pose3 difference = a.Inverse() * b;
  return difference.translation_m.norm() < kSamePlaceM &&
         RotationAngle(difference.rotation) < kSamePlaceRad;
}

bool AmongThem(std::span<const Pose3> places, const Pose3& place) {
  return std::ranges::any_of(places, [&](const Pose3& one) { return SamePlace(one, place); });
}

// False when the way leads to one of the places `known` and was left there.
bool Descend(const PyramidLevel& i,
             const SourcePoints& j,
             const AlignmentOptions& options,
             Descent& descent,
             std::span<const Pose3> known = {}) {
  const bool near = j.choice().near;
  descent.structural.reset();
  Mixing mixing;
  WayLeft way_left;
  for (int n = 0; n < options.max_iterations; ++n) {
    descent.system =
        BuildAlignmentSystem(i, j, descent.i_from_j, descent.gates, options.pyramid.noise);
    descent.stride = j.choice().stride;
    TakeScales(descent.system, near, descent.gates);
    const Vector6d free = Step(descent, Measured(j, options, descent));
    const Vector6d step = free - descent.held.Part(free);
    // Far off the next stripe or tile may lie where the steps seem to lead.
    const Vector6d move = near ? mixing.Move(step) : step;
    descent.i_from_j = V2t(move) * descent.i_from_j;
    if (AmongThem(known, descent.i_from_j)) return false;
    if (way_left.Behind(step, j.level().camera.fx) < descent.converged_px) break;
  }
  return true;
}

AlignmentGates LevelGates(const AlignmentOptions& options,
                          std::size_t levels_above_finest_skipped) {
  AlignmentGates gates;
  gates.max_distance_m = static_cast<float>(
      options.max_distance_m / std::pow(2.0, static_cast<double>(levels_above_finest_skipped)));
  gates.min_normal_cosine = static_cast<float>(std::cos(options.max_normal_angle_deg * kRadPerDeg));
  return gates;
}

// Information per texel that the two images share, nats: that of jointly normal variables. Where
// one contrast outweighs all (a light wall over a dark floor), the correlation itself is near 1
// wherever the frames lie along it.
double SharedInformation(const PlaceJudgement& place) {
  if (!SeesImages(place)) return 0;
  const double correlation = std::clamp(place.intensity_correlation, 0.0, kFullCorrelation);
  return -0.5 * std::log(1 - correlation * correlation);
}

PlaceJudgement JudgeCoarsely(const PyramidLevel& i,
                             const SourcePoints& j,
                             const Pose3& i_from_j,
                             const AlignmentOptions& options) {
  PlaceGates gates = LevelGates(options, 0);
  gates.geometric_scale = kJudgeScale;
  return JudgePlace(i, j, i_from_j, gates, options.pyramid.noise);
}

// What competing starts are judged by: over the common points, geometric agreement at a common
// scale and correlation of the images. Of a pattern's pixels most fit anywhere to within a robust
// scale; the correlation lives by the few strong ones. Larger overlap counts for more, but less
// than likeness: a wrong place may well show more of the other frame.
double SupportAt(const Pose3& i_from_j,
                 const PyramidLevel& i,
                 const SourcePoints& j,
                 const AlignmentOptions& options) {
  const PlaceJudgement place = JudgeCoarsely(i, j, i_from_j, options);
  if (place.num_overlap == 0) return 0;
  const double images = place.num_photometric * std::max(0.0, place.intensity_correlation);
  const double likeness = (place.support + images) / place.num_overlap;
  return likeness * std::sqrt(static_cast<double>(place.num_overlap) / place.num_source);
}

// Directions that depth leaves open at `i_from_j`, weakest first: unit vectors of a left
// perturbation whose rotations count by their arc at the mean distance.
std::vector<Vector6d> OpenDirections(const AlignmentSystem& system) {
  const Matrix6d geometric = system.hessian - system.photometric_hessian;
  const std::optional<ArcSpectrum> spectrum = SpectrumByArc(geometric);
  if (!spectrum) return {};
  std::vector<Vector6d> open;
  for (int k = 0; k < 3 && spectrum->values[k] < kOpenRatio * spectrum->values[5]; ++k)
    open.push_back(spectrum->Perturbation(spectrum->directions.col(k)));
  return open;
}

// Points of frame j's coarsest level: descents that compete go by a part of them, and all tell
// which end is right, seldom.
class CoarsePoints {
 public:
  CoarsePoints(const PyramidLevel& level, const AlignmentOptions& options)
      : level_(level), options_(options), part_(FarPoints(level, CoarsestStride(level), options)) {}

  [[nodiscard]] const PyramidLevel& level() const { return level_; }
  [[nodiscard]] const SourcePoints& part() const { return part_; }
  [[nodiscard]] const SourcePoints& all() {
    if (!all_) all_.emplace(FarPoints(level_, 1, options_));
    return *all_;
  }

 private:
  const PyramidLevel& level_;
  const AlignmentOptions& options_;
  SourcePoints part_;
  std::optional<SourcePoints> all_;
};

// What places along a direction that depth leaves open are judged by: the common points alone,
// since how many there are is least where the camera moved most.
struct Likeness {
  double value = 0;       // of geometry and images, per point
  double resolution = 0;  // differences below this are chance
};

Likeness JudgeLikeness(const PyramidLevel& i,
                       const SourcePoints& j,
                       const Pose3& i_from_j,
                       const AlignmentOptions& options) {
  const PlaceJudgement place = JudgeCoarsely(i, j, i_from_j, options);
  if (place.num_overlap == 0) return {};
  const double independent =
      place.num_photometric / CorrelationFactor(j, options.photometric_correlation_length_px);
  return {place.support / place.num_overlap + SharedInformation(place),
          kSureNats / std::max(1.0, independent)};
}

// Of steps to both sides the one that is surely more like than none; 0 where none is. Every second
// one is judged, and those between where the likeness might rise to the best one as steeply as it
// falls from none.
template <typename JudgeStep>
int BestStep(const JudgeStep& judge_step) {
  const Likeness here = judge_step(0);
  const double before = judge_step(-1).value, behind = judge_step(1).value;
  const double rise = std::max(0.0, here.value - std::min(before, behind));
  int best = 0;
  double best_value = here.value + here.resolution;
  const auto take = [&](int n, double value) {
    if (value <= best_value) return;
    best = n;
    best_value = value;
  };
  take(-1, before);
  take(1, behind);
  for (const int side : {-1, 1}) {
    double last = side < 0 ? before : behind;
    for (int n = 2; n <= kNumOpenSteps; n += 2) {
      const double value = judge_step(side * n).value;
      take(side * n, value);
      const bool skipped = n > 2;
      if (skipped && std::max(last, value) + rise > best_value)
        take(side * (n - 1), judge_step(side * (n - 1)).value);
      last = value;
    }
  }
  return best;
}

// Where depth leaves a direction open, only the images tell the place along it, and their descent
// ends at the nearest stripe, tile or board that looks alike. So places on both sides are tried.
Descent SearchOpenDirections(const PyramidLevel& i,
                             CoarsePoints& j,
                             const AlignmentOptions& options,
                             const Descent& descent) {
  Descent best = descent;
  for (const Vector6d& direction : OpenDirections(descent.system)) {
    const double step_m = kOpenStepPx * MeanDepthM(j.level()) / j.level().camera.fx;
    const Descent centre = best;
    Descent tried = centre;
    const auto place_at = [&](int n) { return V2t(n * step_m * direction) * centre.i_from_j; };
    const int best_step = BestStep([&](int n) {
      return JudgeLikeness(i, j.part(), n == 0 ? centre.i_from_j : place_at(n), options);
    });
    if (best_step == 0) continue;
    tried.i_from_j = place_at(best_step);
    if (SamePlace(tried.i_from_j, centre.i_from_j)) continue;
    tried.start_i_from_j = tried.i_from_j;
    Descend(i, j.all(), options, tried);
    const Likeness before = JudgeLikeness(i, j.all(), centre.i_from_j, options);
    const Likeness after = JudgeLikeness(i, j.all(), tried.i_from_j, options);
    if (after.value > before.value + before.resolution) best = tried;
  }
  return best;
}

// Whether nothing speaks for another place. Such a place was never left for one that was better, on
// 22 captures, two of them real.
bool IsSure(const AlignmentSystem& system) {
  return SeesImages(system) && system.intensity_correlation >= kSureCorrelation &&
         system.num_inliers >= kSureAgreement * system.num_overlap;
}

// Where descents from the starts end, each place once; the first one alone where that is enough.
std::vector<Descent> DescendFromAll(std::span<const Pose3> starts,
                                    const OtherStarts& others,
                                    const PyramidLevel& i,
                                    const SourcePoints& j,
                                    const AlignmentOptions& options) {
  std::vector<Descent> descents;
  std::vector<Pose3> tried, ends;
  const auto descend_from = [&](const Pose3& start) {
    const bool is_new = !AmongThem(tried, start);
    tried.push_back(start);
    if (!is_new) return;
    Descent descent = DescentFrom(start);
    descent.gates = LevelGates(options, 0);
    descent.gates.geometric_scale = kFirstScale;
    descent.gates.photometric_scale = kFirstPhotometricScale;
    if (!Descend(i, j, options, descent, ends)) return;
    ends.push_back(descent.i_from_j);
    descents.push_back(descent);
  };
  descend_from(starts.front());
  if (!others.always && IsSure(descents.front().system)) return descents;
  for (const Pose3& start : starts.subspan(1)) descend_from(start);
  if (!others.search) return descents;
  if (const std::optional<Pose3> found = others.search()) descend_from(*found);
  return descents;
}

// By every second row and column; which end is right is told by all.
Descent BestCoarseDescent(const PyramidLevel& i,
                          CoarsePoints& j,
                          std::span<const Pose3> starts,
                          const OtherStarts& others,
                          const AlignmentOptions& options) {
  const std::vector<Descent> descents = DescendFromAll(starts, others, i, j.part(), options);
  if (descents.size() == 1) return descents.front();
  std::vector<double> support;
  for (const Descent& descent : descents)
    support.push_back(SupportAt(descent.i_from_j, i, j.all(), options));
  return descents[static_cast<std::size_t>(std::ranges::max_element(support) - support.begin())];
}

// The finest level's system at the end of a descent, judged by both frames.
void JudgeEnd(const PyramidLevel& i,
              const SourcePoints& j,
              int batch_stride,
              const AlignmentOptions& options,
              Descent& descent) {
  AlignmentGates gates = descent.gates;
  gates.cross_frames = true;
  gates.batch_stride = batch_stride;
  descent.system = BuildAlignmentSystem(i, j, descent.i_from_j, gates, options.pyramid.noise);
  descent.stride = j.choice().stride;
}

// Along what depth alone does not see, the end is brought back to `start_i_from_j`, and the descent
// goes on in the other directions (solution remapping: Zhang, Kaess, Singh 2016).
void HoldUnseen(const PyramidLevel& i,
                const SourcePoints& j,
                const Pose3& start_i_from_j,
                int judged_stride,
                const AlignmentOptions& options,
                Descent& descent) {
  if (SeesImages(descent.system)) return;
  descent.held = Unseen(descent.system.hessian);
  if (descent.held.empty()) return;
  const Vector6d moved = T2v(descent.i_from_j * start_i_from_j.Inverse());
  descent.i_from_j = V2t(moved - descent.held.Part(moved)) * start_i_from_j;
  Descend(i, j, options, descent);
  JudgeEnd(i, j, judged_stride, options, descent);
}

// The Hessian as information of independent measurements, of a left perturbation, made positive
// semidefinite; and the share of its weakest direction, rotations measured by their arc at the mean
// distance.
struct JudgedHessian {
  Matrix6d left = Matrix6d::Zero();
  double ratio = 0;
};

// Along a direction in metres, rotations by their arc.
double InformationOfStart(const Vector6d& direction,
                          const Vector6d& scale,
                          const StartSigma& sigma) {
  Vector6d sigmas_m = scale;
  sigmas_m.head<3>() *= sigma.translation_m;
  sigmas_m.tail<3>() *= sigma.rotation_rad;
  return 1 / direction.cwiseProduct(sigmas_m).squaredNorm();
}

JudgedHessian Judge(const AlignmentSystem& system,
                    const PyramidLevel& finest,
                    int stride,
                    const StartSigma& start_sigma,
                    const AlignmentOptions& options) {
  const Matrix6d& photometric = system.photometric_hessian;
  const Matrix6d raw =
      (system.hessian - photometric) /
          CorrelationFactor(finest, options.correlation_length_px, stride) +
      photometric / CorrelationFactor(finest, options.photometric_correlation_length_px, stride);
  const std::optional<ArcSpectrum> spectrum = SpectrumByArc(raw);
  if (!spectrum) return {};
  const Matrix6d& directions = spectrum->directions;
  const Vector6d& scale = spectrum->scale;
  Vector6d values = spectrum->values.cwiseMax(0.0);
  const double ratio = values[5] > 0 ? values[0] / values[5] : 0;
  const double least = SeesImages(system) ? 0 : kUnseenRatio * values[5];
  for (int k = 0; k < 6 && values[k] < least; ++k)
    values[k] = InformationOfStart(directions.col(k), scale, start_sigma);
  const Matrix6d clamped = directions * values.asDiagonal() * directions.transpose();
  return {scale.asDiagonal() * clamped * scale.asDiagonal(), ratio};
}

Matrix6d Information(const Matrix6d& left,
                     const Pose3& i_from_j,
                     const StartSigma& start_sigma,
                     const AlignmentOptions& options) {
  // A perturbation in frame j (right) is Adjoint(i_from_j) times as large in frame i (left).
  const Matrix6d adjoint = Adjoint(i_from_j);
  Matrix6d right = adjoint.transpose() * left * adjoint;
  // Directions that nothing constrains keep the prior that held them.
  const double prior_m = std::max(kPrior.translation_m, start_sigma.translation_m);
  const double prior_rad = std::max(kPrior.rotation_rad, start_sigma.rotation_rad);
  right.diagonal().head<3>().array() += 1 / (prior_m * prior_m);
  right.diagonal().tail<3>().array() += 1 / (prior_rad * prior_rad);
  Matrix6d covariance = right.ldlt().solve(Matrix6d::Identity());
  covariance.diagonal().head<3>().array() +=
      options.floor_translation_m * options.floor_translation_m;
  const double floor_rad = options.floor_rotation_deg * kRadPerDeg;
  covariance.diagonal().tail<3>().array() += floor_rad * floor_rad;
  const Matrix6d information =
      (0.5 * (covariance + covariance.transpose())).ldlt().solve(Matrix6d::Identity());
  return 0.5 * (information + information.transpose());
}

FrameAlignment Conclude(const Descent& descent,
                        const PyramidLevel& finest,
                        const StartSigma& start_sigma,
                        const AlignmentOptions& options) {
  const AlignmentSystem& system = descent.system;
  FrameAlignment result;
  result.i_from_j = descent.i_from_j;
  const JudgedHessian judged = Judge(system, finest, descent.stride, start_sigma, options);
  result.information = Information(judged.left, descent.i_from_j, start_sigma, options);
  const double num_source = std::max(1, system.num_source);
  result.rmse_m =
      system.num_inliers > 0 ? std::sqrt(system.sum_squared_m2 / system.num_inliers) : 0;
  result.inlier_share = system.num_inliers / num_source;
  result.overlap = system.num_overlap / num_source;
  result.inside = system.num_inside / num_source;
  result.constraint_ratio = judged.ratio;
  result.held = !descent.held.empty();
  result.degenerate = judged.ratio < options.degenerate_ratio;
  result.inlier_ratio = static_cast<double>(system.num_inliers) / std::max(1, system.num_overlap);
  const bool has_colour = SeesImages(system);
  if (has_colour) result.intensity_correlation = system.intensity_correlation;
  const bool like = has_colour && result.intensity_correlation >= kLikeImages;
  const double min_inlier_ratio = (like ? kAgreementOfLikeImages : 1) * options.min_inlier_ratio;
  result.ok = result.overlap >= options.min_overlap && result.inlier_ratio >= min_inlier_ratio &&
              result.intensity_correlation >= options.min_intensity_correlation;
  return result;
}

bool Comparable(const FramePyramid& i, const FramePyramid& j) {
  return !i.empty() && i.levels.size() == j.levels.size();
}

FrameAlignment Failed(const Pose3& i_from_j) {
  FrameAlignment failed;
  failed.i_from_j = i_from_j;
  return failed;
}

AlignmentOptions WithNoiseOf(const FramePyramid& i,
                             const FramePyramid& j,
                             const AlignmentOptions& user_options) {
  AlignmentOptions options = user_options;
  options.pyramid.noise = options.pyramid.noise.Scaled(std::max(i.noise_scale, j.noise_scale));
  return options;
}

// Down the `num_levels` finest levels, and judged at the end.
void DescendToFinest(const FramePyramid& i,
                     const FramePyramid& j,
                     std::size_t num_levels,
                     const Pose3& first_start,
                     const DescentEnd& end,
                     const AlignmentOptions& options,
                     Descent& descent) {
  const std::size_t coarsest = NumAlignmentLevels(i) - 1;
  const auto take_gates = [&](std::size_t level) {
    AlignmentGates gates = LevelGates(options, coarsest - level);
    gates.geometric_scale = 2 * descent.gates.geometric_scale;
    gates.photometric_scale = 2 * descent.gates.photometric_scale;
    gates.gain = descent.gates.gain;
    gates.bias = descent.gates.bias;
    gates.falloff = descent.gates.falloff;
    descent.gates = gates;
  };
  for (std::size_t level = num_levels; level-- > 1;) {
    take_gates(level);
    descent.converged_px = kConvergedMiddlePx;
    const PyramidLevel& source = j.levels[level];
    Descend(i.levels[level], NearPoints(source, MiddleStride(source), options), options, descent);
  }
  const PyramidLevel& finest = i.levels.front();
  const PyramidLevel& source = j.levels.front();
  const SourcePoints points =
      num_levels > 0 ? NearPoints(source, Stride(source), options) : FarPoints(source, 1, options);
  if (num_levels > 0) {
    take_gates(0);
    descent.converged_px = end.converged_px;
    Descend(finest, points, options, descent);
  }
  JudgeEnd(finest, points, end.judged_stride, options, descent);
  HoldUnseen(finest, points, first_start, end.judged_stride, options, descent);
}

// Told at the coarsest level.
bool SeesTheSame(const FramePyramid& i,
                 const FramePyramid& j,
                 const Pose3& i_from_j,
                 const AlignmentOptions& options) {
  const std::size_t coarsest = NumAlignmentLevels(i) - 1;
  const PlaceJudgement there = JudgeCoarsely(
      i.levels[coarsest], FarPoints(j.levels[coarsest], 1, options), i_from_j, options);
  return there.num_overlap >= kNearOverlap * options.min_overlap * there.num_source;
}

}  // namespace

FrameAlignment AlignPyramids(const FramePyramid& i,
                             const FramePyramid& j,
                             std::span<const Pose3> initial_i_from_j,
                             const AlignmentOptions& user_options,
                             const StartSigma& start_sigma,
                             const OtherStarts& others) {
  DEEPSLAM_CHECK(!initial_i_from_j.empty(), "alignment needs a start");
  if (!Comparable(i, j)) return Failed(initial_i_from_j.front());
  DEEPSLAM_CHECK(IsReference(i), "frames are aligned to targets");
  const AlignmentOptions options = WithNoiseOf(i, j, user_options);
  const std::size_t coarsest = NumAlignmentLevels(i) - 1;
  const PyramidLevel& coarsest_i = i.levels[coarsest];
  CoarsePoints coarsest_j(j.levels[coarsest], options);
  Descent descent = BestCoarseDescent(coarsest_i, coarsest_j, initial_i_from_j, others, options);
  if (options.photometric && (others.always || !IsSure(descent.system)))
    descent = SearchOpenDirections(coarsest_i, coarsest_j, options, descent);
  DescendToFinest(i, j, coarsest, initial_i_from_j.front(), kPlaced, options, descent);
  return Conclude(descent, j.levels.front(), start_sigma, options);
}

double Support(const FramePyramid& i,
               const FramePyramid& j,
               const Pose3& i_from_j,
               const AlignmentOptions& user_options) {
  if (!Comparable(i, j)) return 0;
  const AlignmentOptions options = WithNoiseOf(i, j, user_options);
  const std::size_t coarsest = NumAlignmentLevels(i) - 1;
  const SourcePoints points = FarPoints(j.levels[coarsest], 1, options);
  return SupportAt(i_from_j, i.levels[coarsest], points, options);
}

FrameAlignment RefineAlignment(const FramePyramid& i,
                               const FramePyramid& j,
                               const Pose3& i_from_j,
                               const AlignmentOptions& user_options) {
  if (!Comparable(i, j)) return Failed(i_from_j);
  DEEPSLAM_CHECK(IsReference(i), "frames are aligned to targets");
  const AlignmentOptions options = WithNoiseOf(i, j, user_options);
  if (!SeesTheSame(i, j, i_from_j, options)) return Failed(i_from_j);
  Descent descent = DescentFrom(i_from_j);
  descent.gates.geometric_scale = kNearScale;
  descent.gates.photometric_scale = kNearPhotometricScale;
  const std::size_t num_levels = std::min(kNearLevels, NumAlignmentLevels(i));
  DescendToFinest(i, j, num_levels, i_from_j, kMeasured, options, descent);
  return Conclude(descent, j.levels.front(), {}, options);
}

FrameAlignment Sharpened(const FrameAlignment& found,
                         const FramePyramid& i,
                         const FramePyramid& j,
                         const AlignmentOptions& options) {
  if (!found.ok || found.held) return found;
  const FrameAlignment sharpened = RefineAlignment(i, j, found.i_from_j, options);
  return sharpened.ok ? sharpened : found;
}

void Describe(OptionsVisitor& visitor, AlignmentOptions& options) {
  Describe(visitor, options.pyramid);
  visitor.Field("photometric", options.photometric, "join a photometric term to ICP");
  visitor.Field("max_iterations", options.max_iterations, {1, 100}, "1", "iterations per level");
  visitor.Field("max_distance_m",
                options.max_distance_m,
                {0.01, 5},
                "m",
                "association gate at the coarsest level, halved at each finer one");
  visitor.Field("max_normal_angle_deg",
                options.max_normal_angle_deg,
                {5, 90},
                "deg",
                "largest angle between the normals of a correspondence");
  visitor.Field("min_overlap",
                options.min_overlap,
                {0.01, 1},
                "1",
                "share of the points that must fall on valid points of the other frame");
  visitor.Field("min_agreement",
                options.min_inlier_ratio,
                {0.01, 1},
                "1",
                "share of the overlap that must agree within three standard deviations");
  visitor.Field("min_brightness_correlation",
                options.min_intensity_correlation,
                {-1, 1},
                "1",
                "correlation of the two images' intensities that an alignment must reach");
  visitor.Field("correlation_length_px",
                options.correlation_length_px,
                {1, 100},
                "px",
                "length over which depth errors are shared, pixels of a 640 pixel wide image");
  visitor.Field("photometric_correlation_length_px",
                options.photometric_correlation_length_px,
                {1, 300},
                "px",
                "length over which brightness errors are shared, pixels of a 640 pixel wide image");
  visitor.Field("floor_translation_m",
                options.floor_translation_m,
                {0, 1},
                "m",
                "systematic error of an alignment, one standard deviation");
  visitor.Field("floor_rotation_deg",
                options.floor_rotation_deg,
                {0, 30},
                "deg",
                "systematic error of an alignment, one standard deviation");
  visitor.Field("degenerate_ratio",
                options.degenerate_ratio,
                {0, 1},
                "1",
                "weakest direction's share of the strongest one's information, below which a frame "
                "is degenerate");
}

}  // namespace deepslam::alignment
