// The heights at which tops of tables lie, and what a frame shows there.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/geometry/plane.h"
#include "deepslam/scene/ground.h"
#include "deepslam/segment/connect.h"
#include "deepslam/segment/image_pieces.h"
#include "deepslam/segment/region.h"

namespace deepslam::segment {

// A share of a piece's pixels that may rise above the top that ends it: noise.
inline constexpr double kMostAbove = 0.05;

// Pixels this near to the top's height are the top.
[[nodiscard]] inline double TopThicknessAt(double depth_m) {
  constexpr double kBoardThickness_m = 0.025;  // of boards and noise right before the camera
  constexpr double kThicknessPerM2 = 0.005;  // plus this times the squared depth
  return kBoardThickness_m + kThicknessPerM2 * depth_m * depth_m;
}

// Where a point in camera axes lies on the ground.
struct GroundAxes {
  Eigen::Matrix<double, 3, 2> basis;

  explicit GroundAxes(const Plane& ground_camera)
      : basis(GroundTangentBasis(ground_camera.normal)) {}
  [[nodiscard]] double Along(int axis, double x, double y, double z) const {
    return basis(0, axis) * x + basis(1, axis) * y + basis(2, axis) * z;
  }
};

// How high the pixels of a piece lie, in steps of heights at which tops are.
struct PieceHeights {
  static constexpr int kNumBins =
      51;  // of kBin_m from kLowestTop_m to kHighestTop_m (top_heights.cc)

  int all = 0;                               // pixels
  std::array<int, kNumBins + 1> from_bin{};  // of them in this bin or higher
};

// Of every piece.
[[nodiscard]] std::vector<PieceHeights> HeightsOf(const ImagePieces& pieces);

// What a region holds at the heights where tops are.
class HeightLayers {
 public:
  HeightLayers(const ImagePieces& pieces,
               std::span<const PieceHeights> heights,
               const Region& region,
               const Owners& owners);

  // Heights at which more lies than just above and below.
  [[nodiscard]] std::vector<double> PeakHeights() const;
  // The largest connected part of what is at the height: level surface, or pieces that end there,
  // as the rim of a top does whose middle returns no depth.
  [[nodiscard]] std::vector<PixelPoint> At(double height_m) const;

 private:
  struct Pixel {
    int u, v;
  };
  [[nodiscard]] bool EndsAt(std::int32_t piece, double height_m, double thickness_m) const;

  const ImagePieces* pieces_;
  std::span<const PieceHeights> heights_;  // per piece
  std::vector<Pixel> pixels_;
  std::vector<float> height_m_;  // of the pixels
  std::vector<float> depth_m_;
};

}  // namespace deepslam::segment
