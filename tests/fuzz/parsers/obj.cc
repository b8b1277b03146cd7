// Furniture in OBJ; the bytes are their own material library.
#include <string>

#include "deepslam/synth/obj_model.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(obj) {
  const std::string text(bytes);
  const auto beside = [&](const std::string& name) -> std::optional<std::string> {
    DEEPSLAM_CHECK(StaysBelow(name), "what a model names lies beside it");
    return text;
  };
  const auto model = synth::ParseObjModel(text, beside, Eigen::Matrix3d::Identity(), std::nullopt);
  return model.ok();
}
