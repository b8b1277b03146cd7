#include "deepslam/report/warnings.h"

#include <map>

#include <fmt/format.h>

namespace deepslam::report {

std::vector<std::string> Warnings(std::span<const std::string> capture_warnings,
                                  const Association& association,
                                  const Proposals& proposals,
                                  const ObjectMap& map) {
  std::vector<std::string> warnings(capture_warnings.begin(), capture_warnings.end());
  warnings.insert(warnings.end(), proposals.notes.begin(), proposals.notes.end());
  warnings.insert(warnings.end(), map.dropped.begin(), map.dropped.end());
  std::map<std::string, int> reasons;
  for (const Rejection& rejection : association.rejections) ++reasons[rejection.reason];
  for (const auto& [reason, count] : reasons) {
    warnings.push_back(
        fmt::format("{} to no object: {}",
                    count == 1 ? "1 detection belongs" : fmt::format("{} detections belong", count),
                    reason));
  }
  return warnings;
}

}  // namespace deepslam::report
