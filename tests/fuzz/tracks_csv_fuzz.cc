// Tables with a row per time and point.
#include "datasets/formats/tracks_csv.h"
#include "tests/fuzz/track_round_trip.h"

int clothid::FuzzTracksCsv(const std::uint8_t* data, std::size_t size) {
  CheckRoundTrip(AsText(data, size), &ReadTracksCsv, &TracksCsvText);
  return 0;
}
