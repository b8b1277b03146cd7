// libFuzzer's entry, compiled once per parser.
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace deepslam::fuzz {
bool DEEPSLAM_FUZZED_PARSER(std::string_view bytes);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  deepslam::fuzz::DEEPSLAM_FUZZED_PARSER({reinterpret_cast<const char*>(data), size});
  return 0;
}
