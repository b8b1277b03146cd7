#include "deepslam/dataset/picture_alignment.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>
#include <optional>

#include <fmt/format.h>

namespace deepslam::dataset {
namespace {

// A jump of depth between neighbours, of the nearer one's: at 300 px focal length a surface that is
// seen at 86 degrees.
constexpr float kJump = 0.06F;
// Fewer edges tell nothing of a picture, and fewer pictures nothing of a capture.
constexpr int kFewestEdges = 60;
constexpr std::size_t kFewestSamples = 4;  // pictures with edges
// How many deviations of ranks something else has to be ahead. Of real captures as they are, the
// pictures as they are score 0.7 to 1.4, mirrored ones 0.6 less and more, moved ones less.
constexpr double kAheadTurned = 0.3;
constexpr double kAheadMoved = 0.1;        // less than of turned ones, as a shift changes less
constexpr double kAheadMovedShare = 0.12;  // of the score
// Of the samples that have to agree.
constexpr double kAgreeing = 0.8;
constexpr std::size_t kRankLevels = 2048;  // finer than the 255 steps of 8 bits

struct Pixel {
  int u = 0;
  int v = 0;
};

std::vector<Pixel> EdgesOf(const DepthImage& depth_m) {
  const auto jumps = [](float a, float b) {
    return a > 0 && b > 0 && std::abs(a - b) > kJump * std::min(a, b);
  };
  std::vector<Pixel> edges;
  for (int v = 0; v + 1 < depth_m.height(); ++v) {
    for (int u = 0; u + 1 < depth_m.width(); ++u) {
      const float own = depth_m(u, v);
      if (jumps(own, depth_m(u + 1, v)) || jumps(own, depth_m(u, v + 1))) edges.push_back({u, v});
    }
  }
  return edges;
}

// Means of 3 x 3 pixels.
IntensityImage Smoothed(const IntensityImage& picture) {
  IntensityImage out(picture.width(), picture.height());
  for (int v = 1; v + 1 < picture.height(); ++v) {
    for (int u = 1; u + 1 < picture.width(); ++u) {
      float sum = 0;
      for (int row = v - 1; row <= v + 1; ++row)
        sum += picture(u - 1, row) + picture(u, row) + picture(u + 1, row);
      out(u, v) = sum / 9;
    }
  }
  return out;
}

Image<float> ChangeOf(const IntensityImage& picture) {
  const IntensityImage smooth = Smoothed(picture);
  Image<float> change(picture.width(), picture.height());
  for (int v = 2; v + 2 < picture.height(); ++v) {
    for (int u = 2; u + 2 < picture.width(); ++u) {
      change(u, v) =
          std::hypot(smooth(u + 1, v) - smooth(u - 1, v), smooth(u, v + 1) - smooth(u, v - 1));
    }
  }
  return change;
}

// Of each pixel, the share of pixels that change less.
Image<float> RanksOf(const Image<float>& values) {
  const float highest = *std::max_element(values.begin(), values.end());
  const auto level = [&](float value) {
    return highest > 0 ? static_cast<std::size_t>(value / highest * (kRankLevels - 1)) : 0;
  };
  std::vector<std::size_t> below(kRankLevels + 1, 0);
  for (const float value : values) ++below[level(value) + 1];
  std::partial_sum(below.begin(), below.end(), below.begin());
  Image<float> ranks(values.width(), values.height());
  std::transform(values.begin(), values.end(), ranks.begin(), [&](float value) {
    return static_cast<float>(below[level(value)]) / static_cast<float>(values.size());
  });
  return ranks;
}

// The largest rank within a pixel of each, and what is usual in the picture.
struct Edginess {
  Image<float> ranks;
  double mean = 0;
  double deviation = 1;
};

std::optional<Edginess> EdginessOf(const IntensityImage& picture) {
  if (picture.width() < 8 || picture.height() < 8) return std::nullopt;
  const Image<float> ranks = RanksOf(ChangeOf(picture));
  Edginess edginess{Image<float>(ranks.width(), ranks.height()), 0, 1};
  double sum = 0, sum_of_squares = 0;
  for (int v = 1; v + 1 < ranks.height(); ++v) {
    for (int u = 1; u + 1 < ranks.width(); ++u) {
      float largest = 0;
      for (int row = v - 1; row <= v + 1; ++row)
        largest = std::max({largest, ranks(u - 1, row), ranks(u, row), ranks(u + 1, row)});
      edginess.ranks(u, v) = largest;
      const auto value = static_cast<double>(largest);
      sum += value;
      sum_of_squares += value * value;
    }
  }
  const auto count = static_cast<double>((ranks.width() - 2) * (ranks.height() - 2));
  edginess.mean = sum / count;
  const double variance = sum_of_squares / count - edginess.mean * edginess.mean;
  if (!(variance > 1e-6)) return std::nullopt;  // one colour
  edginess.deviation = std::sqrt(variance);
  return edginess;
}

// Deviations by which colour changes more at the edges, taken elsewhere, than it does anywhere.
// Nothing where too few fall into the picture.
std::optional<double> Score(const Edginess& edginess,
                            const std::vector<Pixel>& edges,
                            const std::function<Pixel(Pixel)>& place) {
  double sum = 0;
  int count = 0;
  for (const Pixel& edge : edges) {
    const Pixel at = place(edge);
    if (at.u < 1 || at.v < 1 || at.u + 1 >= edginess.ranks.width() ||
        at.v + 1 >= edginess.ranks.height()) {
      continue;
    }
    sum += static_cast<double>(edginess.ranks(at.u, at.v));
    ++count;
  }
  if (count < kFewestEdges) return std::nullopt;
  return (sum / count - edginess.mean) / edginess.deviation;
}

// How else colour may lie against depth.
struct Candidate {
  std::string words;  // after "depth fits colour better "
  std::size_t picture = 0;
  std::function<Pixel(Pixel, int width, int height)> place;
  bool turned = false;  // mirrored or turned: nothing near the truth
};

constexpr auto kInPlace = [](Pixel p, int /*width*/, int /*height*/) { return p; };

void AddTurned(std::vector<Candidate>& candidates) {
  candidates.push_back({"mirrored left to right; mirror the images of one of the two",
                        0,
                        [](Pixel p, int w, int) {
                          return Pixel{w - 1 - p.u, p.v};
                        },
                        true});
  candidates.push_back({"mirrored top to bottom; mirror the images of one of the two",
                        0,
                        [](Pixel p, int, int h) {
                          return Pixel{p.u, h - 1 - p.v};
                        },
                        true});
  candidates.push_back({"turned by half a turn; turn the images of one of the two",
                        0,
                        [](Pixel p, int w, int h) {
                          return Pixel{w - 1 - p.u, h - 1 - p.v};
                        },
                        true});
}

void AddMoved(std::vector<Candidate>& candidates) {
  constexpr std::string_view kRemedy =
      "is it registered to colour? Else 'depth_camera' and 'colour_from_depth' in capture.yaml say "
      "where it was seen from";
  for (const double percent : {1.25, 2.5, -1.25, -2.5}) {
    candidates.push_back(
        {fmt::format("{} % of the width to the {}; {}",
                     std::abs(percent),
                     percent > 0 ? "right" : "left",
                     kRemedy),
         0,
         [percent](Pixel p, int w, int) {
           return Pixel{p.u + static_cast<int>(std::lround(percent * w / 100)), p.v};
         }});
    candidates.push_back(
        {fmt::format("{} % of the width {}; {}",
                     std::abs(percent),
                     percent > 0 ? "below" : "above",
                     kRemedy),
         0,
         [percent](Pixel p, int w, int) {
           return Pixel{p.u, p.v + static_cast<int>(std::lround(percent * w / 100))};
         }});
  }
  for (const double scale : {0.9, 1.1}) {
    candidates.push_back(
        {fmt::format("{} times as large; {}", scale, kRemedy), 0, [scale](Pixel p, int w, int h) {
           const auto scaled = [&](int at, int size) {
             return static_cast<int>(std::lround(scale * (at - 0.5 * size) + 0.5 * size));
           };
           return Pixel{scaled(p.u, w), scaled(p.v, h)};
         }});
  }
}

std::vector<Candidate> AllCandidates() {
  std::vector<Candidate> candidates = {{"", 0, kInPlace}};
  AddTurned(candidates);
  AddMoved(candidates);
  for (std::size_t k = 1; k < kPictureOffsets.size(); ++k) {
    const int offset = kPictureOffsets[k];
    candidates.push_back(
        {fmt::format("of {} frame{} {}: the two streams are late against each other; pair them by "
                     "one clock",
                     std::abs(offset),
                     std::abs(offset) == 1 ? "" : "s",
                     offset > 0 ? "later" : "before"),
         k,
         kInPlace});
  }
  return candidates;
}

// Of one sample: a score per candidate; empty where the pictures as they are have none.
using Scores = std::vector<std::optional<double>>;

Scores ScoresOf(const PictureSample& sample, const std::vector<Candidate>& candidates) {
  const std::vector<Pixel> edges = EdgesOf(sample.depth_m);
  const int width = sample.depth_m.width();
  const int height = sample.depth_m.height();
  std::array<std::optional<Edginess>, kPictureOffsets.size()> edginess;
  for (std::size_t k = 0; k < edginess.size(); ++k) {
    const IntensityImage& picture = sample.pictures[k];
    if (picture.width() == width && picture.height() == height) edginess[k] = EdginessOf(picture);
  }
  Scores scores;
  for (const Candidate& candidate : candidates) {
    const std::optional<Edginess>& of_picture = edginess[candidate.picture];
    scores.push_back(
        of_picture
            ? Score(*of_picture, edges, [&](Pixel p) { return candidate.place(p, width, height); })
            : std::nullopt);
  }
  return scores.front() ? scores : Scores();
}

// How far a candidate is ahead of the pictures as they are, where it is so for sure.
struct Ahead {
  double by = 0;
  double score = 0;
};

std::optional<Ahead> AheadBy(const std::vector<Scores>& samples, std::size_t n, bool turned) {
  std::size_t count = 0, agreeing = 0;
  double sum = 0, sum_of_scores = 0;
  for (const Scores& scores : samples) {
    if (!scores[n]) continue;
    const double ahead = *scores[n] - *scores.front();
    ++count;
    agreeing += ahead > 0 ? 1 : 0;
    sum += ahead;
    sum_of_scores += *scores[n];
  }
  if (count < kFewestSamples) return std::nullopt;
  const auto of_all = static_cast<double>(count);
  const Ahead ahead{sum / of_all, sum_of_scores / of_all};
  const double least =
      turned ? kAheadTurned : std::max(kAheadMoved, kAheadMovedShare * ahead.score);
  if (static_cast<double>(agreeing) < kAgreeing * of_all || ahead.by < least) return std::nullopt;
  return ahead;
}

}  // namespace

std::vector<std::string> AlignmentDoubts(std::span<const PictureSample> samples) {
  const std::vector<Candidate> candidates = AllCandidates();
  std::vector<Scores> scores;
  for (const PictureSample& sample : samples) {
    Scores of_sample = ScoresOf(sample, candidates);
    if (!of_sample.empty()) scores.push_back(std::move(of_sample));
  }
  const Candidate* best = nullptr;
  double best_by = 0;
  for (std::size_t n = 1; n < candidates.size(); ++n) {
    const std::optional<Ahead> ahead = AheadBy(scores, n, candidates[n].turned);
    if (!ahead || ahead->by <= best_by) continue;
    best = &candidates[n];
    best_by = ahead->by;
  }
  if (best == nullptr) return {};
  const std::string_view of = best->picture == 0 ? "when it lies " : "to the colour ";
  return {fmt::format(
      "the edges of depth do not lie on those of colour: depth fits better {}{}", of, best->words)};
}

}  // namespace deepslam::dataset
