// TRC files of motion capture.
#include "datasets/formats/trc_file.h"
#include "tests/fuzz/track_round_trip.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace clothid;
  CheckRoundTrip(AsText(data, size), &ReadTrc, &TrcText);
  return 0;
}
