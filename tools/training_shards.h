// Training views on disk: a folder of .npy arrays and one JSON file, for programs in any language.
//
// Layout of the folder (format `deepslam/training_views`, version 2); N views, M models:
//   training_views.json   seed, models in the order of voxels.npy, meaning and shape of every array
//   colour.npy            u1 [N, 128, 128, 3]  crops on white (propose/network_crop.h)
//   silhouette.npy, depth.npy, height.npy   u1 [N, 128, 128]
//   sketch_depth.npy, sketch_silhouette.npy u1 [N, 64, 64]; sketch_normal.npy u1 [N, 64, 64, 3]
//   camera.npy            f4 [N, 7]  azimuth and elevation (rad), distance (m), the object's
//   longest
//                         side (m), visible share; of the crop's camera: the square's side
//                         (tangent), elevation by the ground (rad; -10: unknown)
//   model.npy             i4 [N]     row of voxels.npy
//   voxels.npy            u1 [M, 32768]  64^3 models, index (i * 64 + j) * 64 + k, eight to a byte,
//                         the first in the highest bit (numpy.unpackbits)
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/artifact/json_value.h"
#include "deepslam/core/result.h"
#include "deepslam/priors/training_view.h"
#include "training_models.h"

namespace deepslam::tools {

// Writes beside `folder` and moves it into place when finished.
class TrainingShards {
 public:
  // Errors: a folder that exists and is not empty; one that cannot be made.
  [[nodiscard]] static Result<TrainingShards> Create(const std::filesystem::path& folder,
                                                     std::size_t num_models,
                                                     std::size_t num_views);
  // In order; a model, then its views. Not more of either than was said.
  [[nodiscard]] Status AddModel(const TrainingModel& model);
  [[nodiscard]] Status AddView(const priors::TrainingView& view);
  [[nodiscard]] Status Finish(std::uint64_t seed, bool faults);

 private:
  TrainingShards() = default;
  [[nodiscard]] Status Open(std::string_view name,
                            std::string_view dtype,
                            std::vector<std::size_t> shape,
                            std::string_view meaning);
  [[nodiscard]] Status Append(std::string_view name, const void* bytes, std::size_t count);

  std::filesystem::path folder_;
  std::filesystem::path aside_;
  std::map<std::string, std::ofstream, std::less<>> files_;
  artifact::JsonObject arrays_;
  artifact::JsonArray models_;
};

}  // namespace deepslam::tools
