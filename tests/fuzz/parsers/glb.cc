// `deepslam validate`.
#include "deepslam/gltf/validate.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(glb) {
  const gltf::ValidationReport report = gltf::ValidateGlb(bytes);
  DEEPSLAM_CHECK(
      report.errors.size() <= gltf::kMaxFindings && report.warnings.size() <= gltf::kMaxFindings,
      "findings are bounded");
  for (const gltf::ValidatedObject& object : report.objects)
    DEEPSLAM_CHECK(!report.ok() || object.size_m.allFinite(), "a sound object has a size");
  return report.ok();
}
