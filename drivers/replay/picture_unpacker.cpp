#include "drivers/replay/picture_unpacker.hpp"

#include <libdeflate.h>

namespace ovws {

void PictureUnpacker::Free::operator()(libdeflate_decompressor* decompressor) const {
  libdeflate_free_decompressor(decompressor);
}

PictureUnpacker::PictureUnpacker() : decompressor_(libdeflate_alloc_decompressor()) {}

bool PictureUnpacker::unpack(std::span<const std::byte> packed, std::span<std::byte> picture) {
  return decompressor_ &&
         libdeflate_zlib_decompress(decompressor_.get(), packed.data(), packed.size(),
                                    picture.data(), picture.size(), nullptr) == LIBDEFLATE_SUCCESS;
}

}  // namespace ovws
