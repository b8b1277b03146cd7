// A detector's ONNX file. ONNX Runtime itself is not instrumented.
#include "deepslam/detect/detector.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(onnx) {
  const auto detector = detect::LoadNetworkDetector(bytes, {});
  if (!detector.ok()) {
    DEEPSLAM_CHECK(!detector.error().message.empty(), "a refusal says why");
    return false;
  }
  const auto found = (*detector)->Detect(ColourImage(9, 7, Rgb8{1, 2, 3}));
  return found.ok();
}
