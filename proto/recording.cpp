#include "proto/recording.hpp"

namespace ovws {

int picture_word_bytes(PixelFormat format) {
  return traits_of(format).layout == PixelLayout::words ? 2 : 1;
}

int picture_columns(PixelFormat format, int width) {
  return int(row_bytes(format, width)) / picture_word_bytes(format);
}

}  // namespace ovws
