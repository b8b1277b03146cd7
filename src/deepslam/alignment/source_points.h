// What frame j brings to an alignment: the points of one level that may count, packed, since one
// step after the other goes over them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/alignment/reference_pixels.h"

namespace deepslam::alignment {

struct SourceChoice {
  int stride = 1;           // every stride-th row and column
  bool photometric = true;  // intensity counts, where there is some
  // Beyond the coarsest level, within a pixel or two of the place: intensity counts where a pixel
  // surely shows its own surface, and the lens's falloff is fitted. Far off all that pulls counts.
  bool near = false;
};

// Points [begin, end) of a row: whole lanes, and no more than what is left of a batch that begins
// at a multiple of kBatch.
struct SourceRow {
  int v = 0;
  std::size_t begin = 0;
  std::size_t end = 0;
};

// A pixel's numbers where they are read at once; without initial values.
struct alignas(16) PackedPixel {
  float a, b, c, d;
};

// Rows are filled up to whole lanes with points that have no depth.
class SourcePoints {
 public:
  // Keeps a reference to the level.
  SourcePoints(const PyramidLevel& level, const SourceChoice& choice);

  [[nodiscard]] const PyramidLevel& level() const { return level_; }
  [[nodiscard]] const SourceChoice& choice() const { return choice_; }
  // Of all points of the chosen rows and columns.
  [[nodiscard]] int num_with_normal() const { return num_with_normal_; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] const std::vector<SourceRow>& rows() const { return rows_; }

  // One for each point.
  [[nodiscard]] const float* column() const { return column_.get(); }
  [[nodiscard]] const float* depth_m() const { return depth_m_.get(); }
  // Squared tangent of the ray's angle with the optical axis.
  [[nodiscard]] const float* rho2() const { return rho2_.get(); }
  [[nodiscard]] const PackedPixel* surface() const { return surface_.get(); }      // SurfacePixel
  [[nodiscard]] const PackedPixel* intensity() const { return intensity_.get(); }  // ... and 0
  // 1 or 0.
  [[nodiscard]] const std::int32_t* has_normal() const { return has_normal_.get(); }
  [[nodiscard]] const std::int32_t* has_texture() const { return has_texture_.get(); }

 private:
  void Gather();
  void AddRow(int v, const SurfaceRow& surface, const IntensityRow& intensity);
  void FillLanes();
  void AddRowPieces(int v, std::size_t begin);

  const PyramidLevel& level_;
  const SourceChoice choice_;
  const bool photometric_;
  int num_with_normal_ = 0;
  std::size_t size_ = 0;
  std::vector<SourceRow> rows_;
  std::unique_ptr<float[]> column_, depth_m_, rho2_;
  std::unique_ptr<PackedPixel[]> surface_, intensity_;
  std::unique_ptr<std::int32_t[]> has_normal_, has_texture_;
};

// Whether what a pixel without a normal shows is its own surface's intensity. Behind an outline
// the image is blurred with what is in front and moves with it; beside a gap of the depth it is not
// known who is in front.
[[nodiscard]] bool ShowsItself(const PyramidLevel& level, std::int32_t pixel);

}  // namespace deepslam::alignment
