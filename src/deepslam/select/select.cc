#include "deepslam/select/select.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "deepslam/core/angles.h"
#include "deepslam/core/check.h"
#include "deepslam/core/order_statistics.h"
#include "deepslam/core/parallel.h"
#include "deepslam/geometry/facing.h"
#include "deepslam/select/placed.h"
#include "deepslam/select/score.h"

namespace deepslam::select {
namespace {

constexpr std::array<std::string_view, 2> kModes = {"offline", "greedy"};
// Of a model seen less than this nearly all is the prior's word.
constexpr double kHardlySeenShare = 0.12;
// With less of an object's depth within its reach the model is one of two things cut out as one, or
// not the thing.
constexpr double kOwnShare = 0.75;
// Directions of view within this angle are one side of an object.
constexpr double kOneSideRad = 90 * kRadPerDeg;
// Depth of a surface seen at a steeper angle than this is poor (Nguyen et al. 2012): the noise of a
// Kinect is level up to 60 degrees and grows without bound beyond.
constexpr double kWellSeenRad = 60 * kRadPerDeg;

void AppendNote(std::string& note, const std::string& text) {
  if (!note.empty()) note += "; ";
  note += text;
}

// Median over the views that see a ground of the height of the model's bottom above it.
std::optional<double> GroundGap(const shape::ShapeModel& model,
                                const CandidateRegistration& registration,
                                std::span<const ScoredView> views) {
  const Eigen::Vector3d bottom_world =
      Similarity3::From(registration.world_from_object, registration.scale_m) *
      Eigen::Vector3d(0, 0, model.bottom());
  std::vector<double> gaps;
  for (const ScoredView& view : views) {
    if (!view.ground_camera) continue;
    const double gap =
        view.ground_camera->SignedDistance(view.world_from_camera.Inverse() * bottom_world);
    if (std::isfinite(gap)) gaps.push_back(gap);
  }
  if (gaps.empty()) return std::nullopt;
  return Median(gaps);
}

// Angles about a placed object's vertical between neighbouring cameras, all round; their sum is 2
// pi. Empty without cameras.
std::vector<double> GapsBetweenCameras(const Pose3& world_from_object,
                                       std::span<const Eigen::Vector3d> cameras_world) {
  std::vector<double> azimuths;
  for (const Eigen::Vector3d& camera_world : cameras_world) {
    const Eigen::Vector3d camera = world_from_object.Inverse() * camera_world;
    if (camera.allFinite()) azimuths.push_back(std::atan2(camera.y(), camera.x()));
  }
  if (azimuths.empty()) return {};
  std::sort(azimuths.begin(), azimuths.end());
  std::vector<double> gaps = {azimuths.front() + 2 * std::numbers::pi - azimuths.back()};
  for (std::size_t i = 1; i < azimuths.size(); ++i) gaps.push_back(azimuths[i] - azimuths[i - 1]);
  return gaps;
}

// Of the directions that upright surfaces face, the share that no camera saw well, relative to that
// of a single view; in [0, 1].
double UnseenShare(std::span<const double> gaps) {
  if (gaps.empty()) return 1;
  double unseen_rad = 0;
  for (const double gap : gaps) unseen_rad += std::max(0.0, gap - 2 * kWellSeenRad);
  return std::min(1.0, unseen_rad / (2 * std::numbers::pi - 2 * kWellSeenRad));
}

std::vector<Eigen::Vector3d> CamerasOf(std::span<const ObjectView> views) {
  std::vector<Eigen::Vector3d> cameras_world;
  for (const ObjectView& view : views)
    cameras_world.push_back(view.world_from_camera.translation_m);
  return cameras_world;
}

struct Ranked {
  std::size_t index = 0;
  double deciding = 0;
  bool placed = false;
};

// How far the best of the whole models gets, and how far it would get if depth out of its reach
// were of something else.
struct WholeModels {
  double score = 0;
  double score_within_reach = 0;
};

WholeModels BestWhole(std::span<const ShapeCandidate> candidates,
                      std::span<const CandidateScore> scores,
                      std::span<const double> penalties,
                      const std::vector<bool>& placed) {
  WholeModels best;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (TraitsOf(candidates[i].source).is_partial || !placed[i]) continue;
    best.score = std::max(best.score, scores[i].score - penalties[i]);
    best.score_within_reach =
        std::max(best.score_within_reach, ScoreWithinReach(scores[i]) - penalties[i]);
  }
  return best;
}

// The margin that is the same wherever the candidate stands and whatever was seen.
double FixedMargin(WinningMargin margin) {
  if (margin == WinningMargin::kRefined) return SelectOptions::kRefinedMargin;
  if (margin == WinningMargin::kCompleted) return SelectOptions::kCompletedMargin;
  return 0;
}

// What each candidate's score is compared with less.
std::vector<double> Penalties(std::span<const ShapeCandidate> candidates,
                              std::span<const CandidateRegistration> registrations,
                              std::span<const CandidateScore> scores,
                              std::span<const ObjectView> views) {
  const std::vector<Eigen::Vector3d> cameras_world = CamerasOf(views);
  std::vector<double> penalties(candidates.size(), 0.0);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const SourceTraits& traits = TraitsOf(candidates[i].source);
    if (traits.is_partial) continue;  // has no front of its own
    const Pose3& placed = registrations[i].world_from_object;
    penalties[i] = SelectOptions::kBackPenalty *
                       BackShown(placed.rotation, placed.translation_m, cameras_world) +
                   SelectOptions::kBlockedPenalty * scores[i].front_blocked;
    penalties[i] += FixedMargin(traits.margin);
  }
  const auto unseen_of = [&](std::size_t i) {
    return UnseenShare(GapsBetweenCameras(registrations[i].world_from_object, cameras_world));
  };
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (TraitsOf(candidates[i].source).margin == WinningMargin::kCatalogue)
      penalties[i] += SelectOptions::kCatalogueMargin * unseen_of(i);
  }
  const WholeModels whole = BestWhole(candidates, scores, penalties, Placed(registrations));
  const double out_of_reach = std::max(0.0, whole.score_within_reach - whole.score);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (TraitsOf(candidates[i].source).margin != WinningMargin::kUnseenSides) continue;
    penalties[i] = std::min(
        SelectOptions::kSufficientMargin,
        SelectOptions::kFusedMargin + SelectOptions::kOneSidedMargin * unseen_of(i) + out_of_reach);
  }
  return penalties;
}

// Placed candidates first, then by deciding score, then by id.
std::vector<Ranked> Rank(std::span<const ShapeCandidate> candidates,
                         std::span<const CandidateRegistration> registrations,
                         std::span<const CandidateScore> scores,
                         std::span<const double> penalties) {
  const std::vector<bool> placed = Placed(registrations);
  std::vector<Ranked> ranked;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const double score = std::isfinite(scores[i].score) ? scores[i].score : 0.0;
    ranked.push_back({i, std::max(0.0, score - penalties[i]), placed[i] && score > 0});
  }
  std::stable_sort(ranked.begin(), ranked.end(), [&](const Ranked& a, const Ranked& b) {
    if (a.placed != b.placed) return a.placed;
    if (a.deciding != b.deciding) return a.deciding > b.deciding;
    return candidates[a.index].id < candidates[b.index].id;
  });
  return ranked;
}

// Views in order of arrival; a candidate arrives with the view that proposed it, one of all views
// with the last.
class Arrival {
 public:
  explicit Arrival(std::span<const ObjectView> views) {
    for (std::size_t i = 0; i < views.size(); ++i) order_.push_back(i);
    std::stable_sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
      return views[a].frame < views[b].frame;
    });
    for (std::size_t step = 0; step < order_.size(); ++step) {
      step_of_view_.try_emplace(views[order_[step]].detection, step);
    }
  }
  [[nodiscard]] const std::vector<std::size_t>& order() const { return order_; }
  [[nodiscard]] std::size_t StepOf(const ShapeCandidate& candidate) const {
    const auto it = step_of_view_.find(candidate.view);
    const std::size_t last = order_.empty() ? 0 : order_.size() - 1;
    return it == step_of_view_.end() ? last : it->second;
  }

 private:
  std::vector<std::size_t> order_;
  std::map<DetectionId, std::size_t> step_of_view_;
};

double ScoreSoFar(const CandidateScore& score,
                  const std::vector<std::size_t>& order,
                  std::size_t num_views) {
  std::vector<ViewAgreement> so_far;
  for (std::size_t step = 0; step < num_views; ++step) {
    if (order[step] < score.views.size()) so_far.push_back(score.views[order[step]]);
  }
  return ScoreOf(Pool(so_far), 0.0);
}

// The paper's greedy replacement: a candidate takes over when it agrees better with the depth seen
// so far.
std::vector<Replacement> GreedyHistory(std::span<const ShapeCandidate> candidates,
                                       std::span<const CandidateRegistration> registrations,
                                       std::span<const CandidateScore> scores,
                                       std::span<const ObjectView> views,
                                       std::span<const double> penalties) {
  const Arrival arrival(views);
  const std::vector<bool> placed = Placed(registrations);
  std::vector<Replacement> history;
  for (std::size_t step = 0; step < arrival.order().size(); ++step) {
    std::optional<std::size_t> best;
    double best_score = 0;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (!placed[i] || arrival.StepOf(candidates[i]) > step) continue;
      const double score =
          std::max(0.0, ScoreSoFar(scores[i], arrival.order(), step + 1) - penalties[i]);
      const bool holds = !history.empty() && history.back().candidate == candidates[i].id;
      if (best && (score < best_score || (score == best_score && !holds))) continue;
      best = i;
      best_score = score;
    }
    if (!best) continue;
    if (!history.empty() && history.back().candidate == candidates[*best].id) continue;
    history.push_back({views[arrival.order()[step]].frame, candidates[*best].id, best_score});
  }
  return history;
}

// Largest angle, about the object's vertical, between two cameras that saw it.
double SeenAngle(const MapObject& object, std::span<const ObjectView> views) {
  const std::vector<double> gaps = GapsBetweenCameras(object.world_from_object, CamerasOf(views));
  if (gaps.size() < 2) return 0;
  return 2 * std::numbers::pi - *std::max_element(gaps.begin(), gaps.end());
}

std::string Doubts(const MapObject& object,
                   const ShapeCandidate& winner,
                   const CandidateScore& score,
                   const CandidateRegistration& registration,
                   double seen_angle_rad) {
  std::string note = score.note;
  const int num_registered = NumRegistered(registration.views);
  if (num_registered < 2) AppendNote(note, "registered in one view only");
  if (seen_angle_rad < kOneSideRad) AppendNote(note, "seen from one side only");
  if (score.seen_share < kHardlySeenShare) {
    AppendNote(note,
               "only " + std::to_string(std::lround(100 * score.seen_share)) +
                   " % of its surface was seen");
  }
  const auto num_free = std::count_if(object.views.begin(),
                                      object.views.end(),
                                      [](const auto& view) { return view.ok && view.yaw_free; });
  if (num_registered > 0 && 2 * num_free >= num_registered) {
    AppendNote(note, "rotation about the vertical cannot be told");
  }
  const bool is_partial = TraitsOf(winner.source).is_partial;
  if (is_partial) AppendNote(note, "made of the measurement: sides nobody saw are missing");
  if (!is_partial && score.reached_share < kOwnShare) {
    AppendNote(note,
               std::to_string(std::lround(100 * (1 - score.reached_share))) +
                   " % of what was cut out with it lies far from it: perhaps two things in one");
  }
  if (score.score < SelectOptions::kGoodScore) AppendNote(note, "agrees poorly with the depth");
  return note;
}

// Of the best of candidates none of which won.
std::string WhyNotPlaced(const CandidateScore& score) {
  return "no candidate could be placed: " +
         (score.note.empty() ? "none agrees with the depth" : score.note);
}

// The winner's size at a bound of its class: the true one may lie beyond.
std::string SizeDoubt(const ShapeCandidate& candidate, double scale_m) {
  const double size_m = scale_m * kModelExtent;
  const bool at_min = candidate.min_size_m > 0 && size_m < 1.01 * candidate.min_size_m;
  const bool at_max = candidate.max_size_m > 0 && size_m > 0.99 * candidate.max_size_m;
  return at_min || at_max ? "its size is at the limit for its class" : "";
}

// Why what was placed is no object of the map; empty where it is one.
std::string WhyLeftOut(double scale_m, const SelectOptions& options) {
  const double size_m = scale_m * kModelExtent;
  if (size_m >= options.min_size_m) return {};
  return std::to_string(std::lround(100 * size_m)) + " cm large, less than select.min_size_m";
}

MapObject FillWinner(MapObject object,
                     const ShapeCandidate& winner,
                     const CandidateRegistration& registration,
                     const CandidateScore& score,
                     std::span<const ObjectView> views) {
  object.chosen = winner.id;
  object.source = winner.source;
  object.model = winner.model;
  object.library_id = winner.library_id;
  object.credit = winner.credit;
  object.scale_m = registration.scale_m;
  object.world_from_object = registration.world_from_object;
  object.views = registration.views;
  const double seen_angle_rad = SeenAngle(object, views);
  object.note = Doubts(object, winner, score, registration, seen_angle_rad);
  const std::string size_doubt = SizeDoubt(winner, registration.scale_m);
  if (!size_doubt.empty()) AppendNote(object.note, size_doubt);
  return object;
}

}  // namespace

void Describe(OptionsVisitor& visitor, SelectOptions& options) {
  visitor.Choice(
      "mode",
      options.mode,
      kModes,
      "offline: best over all views; greedy: replacement as views arrive, as in the paper");
  visitor.Field("min_size_m",
                options.min_size_m,
                {0, 10},
                "m",
                "things whose longest side is smaller are left out of the map");
  visitor.Field(
      "min_unnamed_confidence",
      options.min_unnamed_confidence,
      {0, 1},
      "1",
      "what no detection names is left out of the map where its confidence is below this");
}

CandidateScore ScoreCandidate(const ShapeCandidate& candidate,
                              const shape::ShapeModel& model,
                              const CandidateRegistration& registration,
                              std::span<const ObjectView> views,
                              const SelectOptions& options) {
  return ScoreCandidate(candidate, model, registration, PrepareForScoring(views), options);
}

CandidateScore ScoreCandidate(const ShapeCandidate& candidate,
                              const shape::ShapeModel& model,
                              const CandidateRegistration& registration,
                              std::span<const ScoredView> views,
                              const SelectOptions& options) {
  CandidateScore score;
  score.candidate = candidate.id;
  if (!registration.ok || model.empty()) {
    score.note = model.empty() ? "the model is empty" : registration.reason;
    return score;
  }
  std::vector<Similarity3> camera_from_object(views.size());
  score.views.resize(views.size());
  ParallelFor(views.size(), [&](std::size_t i) {
    camera_from_object[i] = Similarity3::From(
        CameraFromObject(registration, views[i].view, i, views[i].world_from_camera),
        registration.scale_m);
    score.views[i] = MeasureAgreement(model, camera_from_object[i], views[i], options);
  });
  score.seen_share = SeenShare(model, camera_from_object, views);
  const Evidence evidence = Pool(score.views);
  score.surface_share = evidence.surface;
  score.coverage_share = evidence.coverage;
  score.reached_share = evidence.reached;
  score.free_violation = evidence.violation;
  score.num_views = NumRegistered(registration.views);
  double excess_m = 0;
  if (const std::optional<double> gap_m = GroundGap(model, registration, views)) {
    excess_m = std::max(0.0, std::abs(*gap_m) - SelectOptions::kGroundTolerance_m);
    if (excess_m > 0) {
      score.note = "its bottom is " + std::to_string(static_cast<int>(std::lround(*gap_m * 100))) +
                   " cm above the ground";
    }
  }
  score.score = ScoreOf(evidence, excess_m);
  return score;
}

MapObject SelectShape(ObjectId id,
                      const std::string& class_name,
                      std::span<const ShapeCandidate> candidates,
                      std::span<const CandidateRegistration> registrations,
                      std::span<const CandidateScore> scores,
                      std::span<const ObjectView> views,
                      const SelectOptions& options) {
  DEEPSLAM_CHECK(candidates.size() == registrations.size() && candidates.size() == scores.size(),
                 "one registration and one score per candidate");
  MapObject object;
  object.id = id;
  object.class_name = class_name;
  const std::vector<double> penalties = Penalties(candidates, registrations, scores, views);
  const std::vector<Ranked> ranked = Rank(candidates, registrations, scores, penalties);
  for (const Ranked& entry : ranked) object.scores.push_back(scores[entry.index]);
  object.history = GreedyHistory(candidates, registrations, scores, views, penalties);
  if (ranked.empty() || !ranked.front().placed) {
    object.note = candidates.empty() ? "no candidate" : WhyNotPlaced(scores[ranked.front().index]);
    return object;
  }
  std::size_t winner = ranked.front().index;
  if (options.mode == "greedy" && !object.history.empty()) {
    const auto it = std::find_if(candidates.begin(), candidates.end(), [&](const auto& candidate) {
      return candidate.id == object.history.back().candidate;
    });
    winner = static_cast<std::size_t>(it - candidates.begin());
  }
  object.note = WhyLeftOut(registrations[winner].scale_m, options);
  if (!object.note.empty()) return object;
  return FillWinner(
      std::move(object), candidates[winner], registrations[winner], scores[winner], views);
}

}  // namespace deepslam::select
