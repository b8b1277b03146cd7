#include "deepslam/eval/shape_similarity.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "deepslam/eval/marching_cubes.h"
#include "deepslam/shape/voxelize.h"
#include "support/box_meshes.h"

namespace deepslam::eval {
namespace {

VoxelGrid Chair() {
  return shape::Voxelize(testing_support::ChairMesh(0.45F, 0.5F, 0.45F, 0.9F, 0.04F)).value();
}

VoxelGrid Box(const Eigen::Vector3f& size) {
  return shape::Voxelize(testing_support::BoxMesh(size)).value();
}

// The protocol written down a second time, straight from its words: no cropping, no index tricks.
double BruteIou(const Volume& a, const Volume& b, double threshold) {
  const auto sample = [](const Volume& v) {
    std::vector<double> lows(3, 1e9);
    std::vector<double> highs(3, -1e9);
    for (int i = 0; i < v.size[0]; ++i)
      for (int j = 0; j < v.size[1]; ++j)
        for (int k = 0; k < v.size[2]; ++k)
          if (v(i, j, k) >= 0.1F) {
            const double at[3] = {double(i), double(j), double(k)};
            for (std::size_t n = 0; n < 3; ++n) {
              lows[n] = std::min(lows[n], at[n]);
              highs[n] = std::max(highs[n], at[n]);
            }
          }
    const double side = std::max({highs[0] - lows[0], highs[1] - lows[1], highs[2] - lows[2]});
    const auto value = [&](double x, double y, double z) {
      const double p[3] = {x, y, z};
      double sum = 0;
      for (std::size_t n = 0; n < 3; ++n)
        if (p[n] < lows[n] - 1e-9 || p[n] > highs[n] + 1e-9) return 0.0;
      for (int i = int(x); i <= int(x) + 1; ++i)
        for (int j = int(y); j <= int(y) + 1; ++j)
          for (int k = int(z); k <= int(z) + 1; ++k)
            if (i < v.size[0] && j < v.size[1] && k < v.size[2])
              sum += std::max(0.0, 1 - std::abs(x - i)) * std::max(0.0, 1 - std::abs(y - j)) *
                     std::max(0.0, 1 - std::abs(z - k)) * static_cast<double>(v(i, j, k));
      return sum;
    };
    std::vector<double> out;
    for (int i = 0; i < 32; ++i)
      for (int j = 0; j < 32; ++j)
        for (int k = 0; k < 32; ++k)
          out.push_back(value((lows[0] + highs[0] - side) / 2 + side * i / 31,
                              (lows[1] + highs[1] - side) / 2 + side * j / 31,
                              (lows[2] + highs[2] - side) / 2 + side * k / 31));
    return out;
  };
  const std::vector<double> x = sample(a);
  const std::vector<double> y = sample(b);
  double both = 0;
  double either = 0;
  for (std::size_t n = 0; n < x.size(); ++n) {
    both += x[n] > threshold && y[n] > threshold ? 1 : 0;
    either += x[n] > threshold || y[n] > threshold ? 1 : 0;
  }
  return both / either;
}

TEST(Pix3dIou, EqualsAnIndependentComputation) {
  const Volume chair(Chair());
  const Volume box(Box({0.4F, 0.7F, 0.9F}));
  const std::vector<double> iou =
      IouPerThreshold(NormaliseForIou(chair).value(), NormaliseForIou(box).value());
  // Away from values that are exactly a threshold, where the last bit decides.
  for (const int n : {4, 13, 27, 43}) {
    EXPECT_NEAR(iou[static_cast<std::size_t>(n - 1)], BruteIou(chair, box, 0.01 * n), 1e-3) << n;
  }
}

TEST(Pix3dIou, OfAShapeWithItselfIsOne) {
  const Volume chair = NormaliseForIou(Volume(Chair())).value();
  EXPECT_THAT(IouPerThreshold(chair, chair), testing::Each(1.0));
}

TEST(Pix3dIou, DoesNotDependOnPlaceOrSizeInTheGrid) {
  Volume large({64, 64, 64});
  Volume small({64, 64, 64});
  for (int i = 0; i < 10; ++i)
    for (int j = 0; j < 6; ++j)
      for (int k = 0; k < 4; ++k) {
        large(i + 40, j + 3, k + 20) = 1;
        small(i, j, k + 59) = 0.7F;  // above every threshold
      }
  EXPECT_THAT(IouPerThreshold(NormaliseForIou(large).value(), NormaliseForIou(small).value()),
              testing::Each(testing::Gt(0.8)));
}

TEST(Pix3dIou, LargeCubesArePooledFirst) {
  Volume fine({128, 128, 128});
  Volume coarse({32, 32, 32});
  for (int i = 2; i < 20; ++i)
    for (int j = 5; j < 12; ++j)
      for (int k = 1; k < 30; ++k) {
        coarse(i, j, k) = 1;
        fine(4 * i + 3, 4 * j, 4 * k + 1) = 1;  // one sample of each pooled cell is enough
      }
  EXPECT_EQ(NormaliseForIou(fine)->values, NormaliseForIou(coarse)->values);
}

TEST(Pix3dIou, ThresholdIsOneForTheWholeSet) {
  std::vector<double> early(kNumIouThresholds, 0.2);
  std::vector<double> late(kNumIouThresholds, 0.2);
  early[4] = 0.9;
  late[30] = 0.7;
  late[4] = 0.6;
  const std::vector<std::vector<double>> set = {early, late};
  const SetIou best = BestOverSet(set);
  EXPECT_NEAR(best.threshold, 0.05, 1e-12);
  EXPECT_NEAR(best.mean, 0.75, 1e-12);
  EXPECT_THAT(best.each, testing::ElementsAre(0.9, 0.6));
}

TEST(Pix3dChamfer, EqualsABruteForceComputation) {
  const auto a = SampleForChamfer(Volume(Chair()), 1).value();
  const auto b = SampleForChamfer(Volume(Box({0.4F, 0.7F, 0.9F})), 1).value();
  ASSERT_EQ(a.size(), 1024U);
  double sum = 0;
  for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)}) {
    for (const Eigen::Vector3d& p : from) {
      double nearest = 1e300;
      for (const Eigen::Vector3d& q : to) nearest = std::min(nearest, (p - q).squaredNorm());
      sum += std::sqrt(nearest) / 1024;
    }
  }
  EXPECT_NEAR(ChamferDistance(a, b), sum, 1e-9);
  EXPECT_GT(sum, 0.05);
}

TEST(Pix3dChamfer, OfAShapeWithItselfIsZero) {
  const auto a = SampleForChamfer(Volume(Chair()), 3).value();
  EXPECT_EQ(ChamferDistance(a, SampleForChamfer(Volume(Chair()), 3).value()), 0.0);
}

TEST(Pix3dChamfer, PointsFillAUnitBox) {
  const auto points = SampleForChamfer(Volume(Chair()), 3).value();
  Eigen::Vector3d low = points[0];
  Eigen::Vector3d high = points[0];
  for (const Eigen::Vector3d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  EXPECT_NEAR((high - low).maxCoeff(), 1.0, 1e-12);
  EXPECT_NEAR((high + low).norm(), 0.0, 1e-12);
}

TEST(ShapeSimilarity, EmptyAndMisshapenVolumesAreErrors) {
  EXPECT_THAT(NormaliseForIou(Volume(VoxelGrid())).error().message, testing::HasSubstr("empty"));
  EXPECT_THAT(SampleForChamfer(Volume(VoxelGrid()), 1).error().message,
              testing::HasSubstr("empty"));
  EXPECT_THAT(NormaliseForIou(Volume({4, 5, 4})).error().message, testing::HasSubstr("cube"));
  Volume hollow({8, 8, 8});
  hollow.values.resize(3);
  EXPECT_FALSE(NormaliseForIou(hollow).ok());
  Volume nan({8, 8, 8});
  std::fill(nan.values.begin(), nan.values.end(), std::nanf(""));
  EXPECT_FALSE(NormaliseForIou(nan).ok());
}

TEST(MarchingCubes, EverySolidGetsAClosedSurface) {
  // A hash of the place: every case of a cell occurs, all ambiguous ones too.
  Volume noise({12, 12, 12});
  for (int i = 1; i < 11; ++i)
    for (int j = 1; j < 11; ++j)
      for (int k = 1; k < 11; ++k)
        noise(i, j, k) =
            static_cast<float>((i * 73 + j * 179 + k * 283 + i * j * k * 37) % 101) / 100;
  for (const float level : {0.1F, 0.5F, 0.8F}) {
    const TriangleMesh mesh = MarchingCubes(noise, level);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
    for (const auto& face : mesh.faces)
      for (std::size_t n = 0; n < 3; ++n) ++sides[{face[n], face[(n + 1) % 3]}];
    std::size_t unpaired = 0;
    for (const auto& [side, count] : sides) {
      const auto back = sides.find({side.second, side.first});
      unpaired += back == sides.end() || back->second != count ? 1 : 0;
    }
    EXPECT_EQ(unpaired, 0U) << level;
    EXPECT_GT(mesh.faces.size(), 100U);
  }
}

TEST(MarchingCubes, VolumeOfABall) {
  Volume ball({40, 40, 40});
  for (int i = 0; i < 40; ++i)
    for (int j = 0; j < 40; ++j)
      for (int k = 0; k < 40; ++k)
        ball(i, j, k) = static_cast<float>(
            15.0 - (Eigen::Vector3d(i, j, k) - Eigen::Vector3d::Constant(19.5)).norm());
  const TriangleMesh mesh = MarchingCubes(ball, 0);
  double volume = 0;
  for (const auto& face : mesh.faces) {
    const auto corner = [&](std::size_t n) { return mesh.vertices[face[n]].cast<double>().eval(); };
    volume += corner(0).dot(corner(1).cross(corner(2))) / 6;
  }
  EXPECT_NEAR(volume, 4.0 / 3.0 * M_PI * 15 * 15 * 15, 0.01 * 14137);  // positive: faces look out
}

}  // namespace
}  // namespace deepslam::eval
