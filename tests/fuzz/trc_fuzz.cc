// TRC files of motion capture.
#include "datasets/formats/trc_file.h"
#include "tests/fuzz/track_round_trip.h"

int clothid::FuzzTrc(const std::uint8_t* data, std::size_t size) {
  CheckRoundTrip(AsText(data, size), &ReadTrc, &TrcText);
  return 0;
}
