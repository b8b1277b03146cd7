// segments.json: the pixels of every detection that are the object, masks as COCO run lengths.
#pragma once

#include <functional>
#include <set>
#include <span>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"
#include "deepslam/scene/detection.h"

namespace deepslam::artifact {

// By pieces: a capture of an hour has fifty megabytes of them.
[[nodiscard]] Status EncodeSegments(std::span<const Segment> segments,
                                    std::string_view name,
                                    const TextSink& sink);
[[nodiscard]] Result<std::vector<Segment>> DecodeSegments(TextSource text, std::string_view name);

// One after another, in their order; an error of `take` ends it.
[[nodiscard]] Status DecodeEachSegment(TextSource text,
                                       std::string_view name,
                                       const std::function<Status(Segment segment)>& take);

// Masks are most of what segments take, and most stages look at those of a few.
[[nodiscard]] Result<std::vector<Segment>> DecodeSegmentsWithoutMasks(TextSource text,
                                                                      std::string_view name);
[[nodiscard]] Result<std::vector<Segment>> DecodeSegmentsOf(const std::set<DetectionId>& wanted,
                                                            TextSource text,
                                                            std::string_view name);

}  // namespace deepslam::artifact
