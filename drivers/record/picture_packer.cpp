#include "drivers/record/picture_packer.hpp"

#include <libdeflate.h>

namespace ovws {
namespace {

constexpr int kLevel =
    1;  // two to four times as fast as higher levels, which save only a few percent

}  // namespace

void PicturePacker::Free::operator()(libdeflate_compressor* compressor) const {
  libdeflate_free_compressor(compressor);
}

PicturePacker::PicturePacker(std::size_t picture_bytes)
    : compressor_(libdeflate_alloc_compressor(kLevel)), packed_(picture_bytes) {}

std::span<const std::byte> PicturePacker::pack(std::span<const std::byte> picture) {
  if (!compressor_) return {};
  const std::size_t bytes = libdeflate_zlib_compress(
      compressor_.get(), picture.data(), picture.size(), packed_.data(), packed_.size());
  return std::span(packed_).first(bytes);
}

}  // namespace ovws
