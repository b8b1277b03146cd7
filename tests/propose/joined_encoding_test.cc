#include "deepslam/propose/joined_encoding.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/core/random.h"

namespace deepslam::propose {
namespace {

using Latents = std::array<float, kNumLatents>;

PriorEncoding Near(Random& random, const Latents& latents, double deviation) {
  PriorEncoding encoding;
  for (std::size_t k = 0; k < kNumLatents; ++k)
    encoding.latents[k] = latents[k] + static_cast<float>(deviation * random.Normal());
  encoding.confidence = 0.5;
  return encoding;
}

double Distance(const Latents& a, const Latents& b) {
  double sum = 0;
  for (std::size_t k = 0; k < kNumLatents; ++k) sum += std::pow(a[k] - b[k], 2);
  return std::sqrt(sum);
}

double SumOfDistances(const Latents& at, const std::vector<PriorEncoding>& views) {
  double sum = 0;
  for (const PriorEncoding& view : views) sum += Distance(at, view.latents);
  return sum;
}

Latents MeanOf(const std::vector<PriorEncoding>& views) {
  Latents mean{};
  for (const PriorEncoding& view : views) {
    for (std::size_t k = 0; k < kNumLatents; ++k)
      mean[k] += view.latents[k] / static_cast<float>(views.size());
  }
  return mean;
}

TEST(JoinEncodings, OneViewStandsForItselfAndTwoMeetInTheMiddle) {
  Random random(1);
  const std::vector<PriorEncoding> views = {Near(random, {}, 1), Near(random, {}, 1)};
  EXPECT_LT(Distance(JoinEncodings(std::span(views).first(1)).latents, views[0].latents), 1e-6);
  EXPECT_LT(Distance(JoinEncodings(views).latents, MeanOf(views)), 1e-5);
  const std::vector<PriorEncoding> alike(4, views[0]);
  EXPECT_LT(Distance(JoinEncodings(alike).latents, views[0].latents), 1e-5);
}

TEST(JoinEncodings, AMisreadViewMovesThemLittle) {
  Random random(2);
  Latents truth{};
  for (float& latent : truth) latent = static_cast<float>(random.Normal());
  Latents wrong{};
  for (float& latent : wrong) latent = static_cast<float>(random.Normal());
  std::vector<PriorEncoding> views;
  for (int n = 0; n < 4; ++n) views.push_back(Near(random, truth, 0.2));
  views.push_back(Near(random, wrong, 0.2));
  const PriorEncoding joined = JoinEncodings(views);
  EXPECT_LT(Distance(joined.latents, truth), 0.6 * Distance(MeanOf(views), truth));
  EXPECT_NEAR(joined.confidence, 0.5, 1e-12);
}

TEST(JoinEncodings, NoOtherPlaceIsCloserToAllViewsInSum) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    std::vector<PriorEncoding> views;
    const std::uint64_t count = 3 + random.Index(8);
    for (std::uint64_t n = 0; n < count; ++n)
      views.push_back(Near(random, {}, random.Uniform(0.1, 2)));
    const Latents joined = JoinEncodings(views).latents;
    const double least = SumOfDistances(joined, views);
    EXPECT_LE(least, SumOfDistances(MeanOf(views), views) + 1e-6);
    for (const PriorEncoding& view : views)
      EXPECT_LE(least, SumOfDistances(view.latents, views) + 1e-2);
    for (int n = 0; n < 20; ++n)
      EXPECT_LE(least, SumOfDistances(Near(random, joined, 0.05).latents, views) + 1e-6);
  }
}

}  // namespace
}  // namespace deepslam::propose
