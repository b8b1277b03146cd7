#include "deepslam/eval/bootstrap.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "deepslam/core/random.h"

namespace deepslam::eval {
namespace {

// An end then varies by 0.7 % of the interval's width from seed to seed.
constexpr int kResamples = 10'000;

}  // namespace

Interval BootstrapMean(std::span<const double> values, std::uint64_t seed) {
  if (values.empty()) return {};
  const auto count = static_cast<double>(values.size());
  Random random(seed, "bootstrap", 0);
  std::vector<double> means;
  for (int n = 0; n < kResamples; ++n) {
    double sum = 0;
    for (std::size_t i = 0; i < values.size(); ++i) sum += values[random.Index(values.size())];
    means.push_back(sum / count);
  }
  std::sort(means.begin(), means.end());
  const auto quantile = [&](double share) {
    return means[static_cast<std::size_t>(std::lround(share * (kResamples - 1)))];
  };
  return {
      std::accumulate(values.begin(), values.end(), 0.0) / count, quantile(0.025), quantile(0.975)};
}

}  // namespace deepslam::eval
