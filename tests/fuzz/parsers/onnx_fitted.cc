// A detector's ONNX file whose input is made smaller. No network is loaded here.
#include "deepslam/detect/fitted_network.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(onnx_fitted) {
  constexpr detect::Sides kPicture = {128, 64};
  const auto fitted = detect::FittedNetwork(bytes, kPicture);
  if (!fitted) return false;
  DEEPSLAM_CHECK(!detect::FittedNetwork(*fitted, kPicture), "what was fitted fits");
  return true;
}
