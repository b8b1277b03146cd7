// Latents of a shape, moved until the decoded shape agrees with all depth of its object: the latent
// optimisation of Hu et al. 2018 and DSP-SLAM (Wang et al. 2021), on the voxels that the depth
// knows something of.
//
//   L(z) = 20 BCE + 1 - Dice + w mean(((z - z0) / u)^2)
//
// u is the root mean square of the start z0. Cross-entropy and Dice run over the known voxels: the
// free ones further than one voxel from the measured surface, with their logits; the solid ones,
// three times as heavy, with the highest logit within one voxel. Without this tolerance a leg that
// the decoder cannot put in its very place is better left away. What nobody saw is the decoder's
// word alone.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/refine/evidence.h"
#include "deepslam/refine/refine_options.h"

namespace deepslam::refine {

// The seam to a network. Both must be deterministic.
struct Decoder {
  // 64^3 logits of latents, index order of VoxelGrid.
  std::function<Result<std::vector<float>>(std::span<const float> latents)> logits;
  // Derivative by the latents of a loss, given that by the logits.
  std::function<Result<std::vector<float>>(std::span<const float> latents,
                                           std::span<const float> by_logits)>
      latent_gradient;
};

struct RefinedLatents {
  std::vector<float> latents;
  double initial_loss = 0;
  double loss = 0;  // <= initial_loss
};

// Errors: InvalidInput when the evidence holds fewer than options.min_voxels solid voxels or the
// start is not finite; whatever the decoder fails with.
[[nodiscard]] Result<RefinedLatents> RefineLatents(std::span<const float> start,
                                                   std::span<const Evidence> evidence,
                                                   const Decoder& decoder,
                                                   const RefineOptions& options);

}  // namespace deepslam::refine
