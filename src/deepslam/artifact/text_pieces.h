// Texts that grow with the length of a capture by megabytes a minute and are never there as a
// whole.
#pragma once

#include <functional>
#include <string_view>

#include "deepslam/core/result.h"

namespace deepslam::artifact {

// Takes the pieces of a text in their order; an error ends the text.
using TextSink = std::function<Status(std::string_view piece)>;
// Hands a text over to a sink.
using TextWriter = std::function<Status(const TextSink& sink)>;

}  // namespace deepslam::artifact
