#include "deepslam/priors/npy.h"

namespace deepslam::priors {

std::string NpyHeader(std::string_view dtype, std::span<const std::size_t> shape) {
  std::string text = "{'descr': '" + std::string(dtype) + "', 'fortran_order': False, 'shape': (";
  for (const std::size_t side : shape) text += std::to_string(side) + ", ";
  text += "), }";
  // Values begin at a multiple of 64 bytes.
  constexpr std::size_t kPrefixBytes = 10;
  constexpr std::size_t kAlign = 64;  // bytes, as numpy itself aligns
  while ((kPrefixBytes + text.size() + 1) % kAlign != 0) text.push_back(' ');
  text.push_back('\n');
  std::string header("\x93NUMPY\x01\x00", 8);
  header.push_back(static_cast<char>(text.size() & 0xFFU));
  header.push_back(static_cast<char>(text.size() >> 8U & 0xFFU));
  return header + text;
}

}  // namespace deepslam::priors
