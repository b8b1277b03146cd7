// Cards that hang before a wall and move from frame to frame: depth and colour of one another.
#include "deepslam/dataset/picture_alignment.h"

#include <cmath>

#include <gmock/gmock.h>

#include "deepslam/core/random.h"

namespace deepslam::dataset {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr int kNumMoments = 24;

struct Card {
  double u, v, width, height;
  double speed_px;  // a frame
  float depth_m;
  float grey;
};

std::vector<Card> Cards() {
  Random random(13);
  std::vector<Card> cards;
  for (int k = 0; k < 9; ++k) {
    cards.push_back({random.Uniform(10, 220),
                     random.Uniform(10, 160),
                     random.Uniform(30, 80),
                     random.Uniform(30, 70),
                     random.Uniform(4, 8),
                     static_cast<float>(random.Uniform(0.8, 2.2)),
                     static_cast<float>(random.Uniform(20, 230))});
  }
  return cards;
}

struct Moment {
  DepthImage depth_m{kWidth, kHeight, 3.0F};
  IntensityImage picture{kWidth, kHeight, 120.0F};
};

Moment At(int moment) {
  Moment seen;
  Random noise(100 + static_cast<std::uint64_t>(moment));
  for (const Card& card : Cards()) {
    const double left = std::fmod(card.u + card.speed_px * moment, kWidth);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const bool on =
            u >= left && u < left + card.width && v >= card.v && v < card.v + card.height;
        if (!on || seen.depth_m(u, v) < card.depth_m) continue;
        seen.depth_m(u, v) = card.depth_m;
        seen.picture(u, v) = card.grey;
      }
    }
  }
  for (float& grey : seen.picture) grey += static_cast<float>(4 * noise.Normal());
  return seen;
}

// Depth of a moment, and colour `late` frames behind it and changed.
template <typename Change>
std::vector<PictureSample> Samples(int late, Change change) {
  std::vector<PictureSample> samples;
  for (int moment = 6; moment + 6 < kNumMoments; moment += 2) {
    PictureSample sample;
    sample.depth_m = At(moment).depth_m;
    for (std::size_t k = 0; k < kPictureOffsets.size(); ++k)
      sample.pictures[k] = change(At(moment + kPictureOffsets[k] - late).picture);
    samples.push_back(std::move(sample));
  }
  return samples;
}

const auto kAsItIs = [](const IntensityImage& picture) { return picture; };

template <typename Place>
auto Moved(const Place& place) {
  return [place](const IntensityImage& picture) {
    IntensityImage out(kWidth, kHeight);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const auto [from_u, from_v] = place(u, v);
        out(u, v) = picture(std::clamp(from_u, 0, kWidth - 1), std::clamp(from_v, 0, kHeight - 1));
      }
    }
    return out;
  };
}

TEST(AlignmentDoubts, PicturesOfOneAnotherAreNotDoubted) {
  EXPECT_THAT(AlignmentDoubts(Samples(0, kAsItIs)), IsEmpty());
}

TEST(AlignmentDoubts, MirroredColourIsNamed) {
  EXPECT_THAT(
      AlignmentDoubts(Samples(0, Moved([](int u, int v) { return std::pair(kWidth - 1 - u, v); }))),
      ElementsAre(HasSubstr("mirrored left to right")));
  EXPECT_THAT(AlignmentDoubts(
                  Samples(0, Moved([](int u, int v) { return std::pair(u, kHeight - 1 - v); }))),
              ElementsAre(HasSubstr("mirrored top to bottom")));
  EXPECT_THAT(AlignmentDoubts(Samples(0, Moved([](int u, int v) {
                                        return std::pair(kWidth - 1 - u, kHeight - 1 - v);
                                      }))),
              ElementsAre(HasSubstr("half a turn")));
}

TEST(AlignmentDoubts, ColourOfAnotherMomentIsNamed) {
  EXPECT_THAT(AlignmentDoubts(Samples(1, kAsItIs)),
              ElementsAre(AllOf(HasSubstr("of 1 frame later"), HasSubstr("late"))));
  EXPECT_THAT(AlignmentDoubts(Samples(2, kAsItIs)), ElementsAre(HasSubstr("of 2 frames later")));
  EXPECT_THAT(AlignmentDoubts(Samples(-2, kAsItIs)), ElementsAre(HasSubstr("of 2 frames before")));
}

TEST(AlignmentDoubts, ColourSeenFromBesideIsNamed) {
  EXPECT_THAT(AlignmentDoubts(Samples(0, Moved([](int u, int v) { return std::pair(u - 8, v); }))),
              ElementsAre(AllOf(HasSubstr("to the right"), HasSubstr("colour_from_depth"))));
}

TEST(AlignmentDoubts, PicturesWithoutEdgesTellNothing) {
  EXPECT_THAT(AlignmentDoubts(Samples(
                  0, [](const IntensityImage&) { return IntensityImage(kWidth, kHeight, 90); })),
              IsEmpty());
  EXPECT_THAT(AlignmentDoubts(Samples(0,
                                      [random = Random(3)](const IntensityImage&) mutable {
                                        IntensityImage noise(kWidth, kHeight);
                                        for (float& grey : noise)
                                          grey = static_cast<float>(random.Uniform(0, 255));
                                        return noise;
                                      })),
              IsEmpty());
  std::vector<PictureSample> flat = Samples(0, kAsItIs);
  for (PictureSample& sample : flat) sample.depth_m = DepthImage(kWidth, kHeight, 2);
  EXPECT_THAT(AlignmentDoubts(flat), IsEmpty());
  EXPECT_THAT(AlignmentDoubts({}), IsEmpty());
  EXPECT_THAT(AlignmentDoubts(std::vector<PictureSample>(6)), IsEmpty());
}

}  // namespace
}  // namespace deepslam::dataset
