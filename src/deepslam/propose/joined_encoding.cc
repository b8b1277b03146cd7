#include "deepslam/propose/joined_encoding.h"

#include <algorithm>

#include <Eigen/Core>

#include "deepslam/core/check.h"

namespace deepslam::propose {
namespace {

using Latents = Eigen::Matrix<double, static_cast<int>(kNumLatents), 1>;

// Of Weiszfeld's iteration for the geometric median, which converges linearly.
constexpr int kWeiszfeldSteps = 30;
constexpr double kLeastDistance = 1e-6;  // latents are about 10 long

Latents LatentsOf(const PriorEncoding& view) {
  return Eigen::Map<const Eigen::Matrix<float, static_cast<int>(kNumLatents), 1>>(
             view.latents.data())
      .cast<double>();
}

Latents MeanOf(std::span<const PriorEncoding> views) {
  Latents sum = Latents::Zero();
  for (const PriorEncoding& view : views) sum += LatentsOf(view);
  return sum / static_cast<double>(views.size());
}

Latents MeanByCloseness(std::span<const PriorEncoding> views, const Latents& to) {
  Latents sum = Latents::Zero();
  double total = 0;
  for (const PriorEncoding& view : views) {
    const Latents latents = LatentsOf(view);
    const double weight = 1 / std::max(kLeastDistance, (latents - to).norm());
    sum += weight * latents;
    total += weight;
  }
  return sum / total;
}

}  // namespace

PriorEncoding JoinEncodings(std::span<const PriorEncoding> views) {
  DEEPSLAM_CHECK(!views.empty(), "at least one view");
  Latents middle = MeanOf(views);
  for (int step = 0; step < kWeiszfeldSteps; ++step) middle = MeanByCloseness(views, middle);
  PriorEncoding joined;
  for (std::size_t k = 0; k < kNumLatents; ++k)
    joined.latents[k] = static_cast<float>(middle[static_cast<Eigen::Index>(k)]);
  for (const PriorEncoding& view : views) joined.confidence += view.confidence;
  joined.confidence /= static_cast<double>(views.size());
  return joined;
}

}  // namespace deepslam::propose
