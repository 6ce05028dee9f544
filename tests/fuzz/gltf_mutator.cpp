// Most changes to the JSON of a glTF file only break its syntax. So half of the changes to an input with a
// binary chunk (gltf.cpp describes this form) affect only the chunk: vertices, indices, keys, images.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most,
                                               unsigned seed) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::size_t zero = text.find('\0');
  if (seed % 2 == 0 || zero == text.npos || text.starts_with("glTF") || zero + 1 >= most)
    return LLVMFuzzerMutate(data, size, most);
  const std::size_t chunk = zero + 1;
  return chunk + LLVMFuzzerMutate(data + chunk, size - chunk, most - chunk);
}
