// The networks of one class that turn a view into a whole shape, in the manner of Pix3D (Sun et al.
// 2018): sketch (crop -> depth, normals, silhouette), encoder (crop and sketch -> latents and
// viewpoint), decoder (latents -> 64^3). Trained by scripts/train.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/geometry/similarity.h"
#include "deepslam/propose/network_crop.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::propose {

inline constexpr std::size_t kNumLatents = 100;  // as the networks are trained (docs/priors.md)

struct PriorEncoding {
  std::array<float, kNumLatents> latents{};
  // Of the camera about the object's z, 0 = in front (+x), (-pi, pi]; and the share [0, 1] of the
  // network's belief that stands behind it.
  double azimuth_rad = 0;
  double confidence = 0;
  double elevation_rad = 0;
};

class ShapePrior {
 public:
  // From the bytes of three ONNX files. InvalidInput names the network and what is wrong: no ONNX,
  // metadata missing or of another class or a newer program, inputs or outputs of another shape.
  [[nodiscard]] static Result<std::unique_ptr<ShapePrior>> Load(std::string_view class_name,
                                                                std::string_view sketch_onnx,
                                                                std::string_view encoder_onnx,
                                                                std::string_view decoder_onnx);
  ~ShapePrior();

  // Thread-safe; equal crops give equal numbers. Errors: values that are not finite.
  [[nodiscard]] Result<PriorEncoding> Encode(const NetworkCrop& crop) const;
  // The shape of the latents, in the canonical frame and of canonical size; small components left
  // out. Errors: values that are not finite; latents that decode to (nearly) nothing. `by_depth`:
  // whether the latents come from crops with depth, for the threshold that goes with it.
  [[nodiscard]] Result<VoxelGrid> Decode(std::span<const float> latents, bool by_depth) const;

  // The same from logits on the decoder's own grid.
  [[nodiscard]] Result<VoxelGrid> Solid(std::span<const float> logits, bool by_depth) const;
  // Where the decoder's own grid lies in the canonical frame of Decode(): the shape is cut, centred
  // and scaled after decoding.
  [[nodiscard]] Result<Similarity3> ObjectFromDecoded(std::span<const float> latents,
                                                      bool by_depth) const;
  // 64^3 logits on the decoder's own grid, index order of VoxelGrid.
  [[nodiscard]] Result<std::vector<float>> Logits(std::span<const float> latents) const;
  // Whether the decoder came with its derivative (scripts/train/decoder_gradient.py).
  [[nodiscard]] bool HasGradient() const;
  // Derivative of a loss by the latents, given that by the logits at these latents. InvalidInput
  // without HasGradient().
  [[nodiscard]] Result<std::vector<float>> LatentGradient(
      std::span<const float> latents, std::span<const float> gradient_by_logits) const;

 private:
  struct Impl;
  explicit ShapePrior(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace deepslam::propose
