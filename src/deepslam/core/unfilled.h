// Vectors whose new elements are left as the memory is, for what is written whole before it is
// read: filling megabytes with zeros first takes as long as some of what is written into them.
#pragma once

#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace deepslam {

// std::allocator, but that elements without a value are not given one.
template <typename T>
struct UnfilledAllocator : std::allocator<T> {
  static_assert(std::is_trivially_default_constructible_v<T>);

  template <typename U>
  struct rebind {
    using other = UnfilledAllocator<U>;
  };

  UnfilledAllocator() = default;
  template <typename U>
  explicit UnfilledAllocator(const UnfilledAllocator<U>& /*other*/) {}

  template <typename U>
  void construct(U* at) {
    ::new (static_cast<void*>(at)) U;
  }
  template <typename U, typename... Values>
  void construct(U* at, Values&&... values) {
    std::construct_at(at, std::forward<Values>(values)...);
  }
};

// UnfilledVector<T>(size) and resize(size): elements of no known value, to be written by the
// caller.
template <typename T>
using UnfilledVector = std::vector<T, UnfilledAllocator<T>>;

}  // namespace deepslam
