// Point tracks for ParaView: a VTK PolyData file (.vtp, XML) per frame, and a collection (.pvd) with their times. For
// output only. Internal to datasets/.
#ifndef CLOTHID_DATASETS_FORMATS_VTP_FILE_H_
#define CLOTHID_DATASETS_FORMATS_VTP_FILE_H_

#include <string>

#include "datasets/formats/point_tracks.h"

namespace clothid {

// The text of frame `frame`: positions as Float64, base64, so that NaN is kept, and the triangles or, where there are
// none, the points as vertices.
std::string VtpText(const PointTracks& tracks, int frame);

// Writes NAME.pvd, where `path` is NAME.pvd or NAME.vtp, and NAME_0000.vtp, .. beside it. Without times the collection
// counts frames. All or none (datasets/files/file_group.h), NAME.pvd last; further frames that an earlier, longer
// collection has left are no part of it. Labels are not kept. Throws `Error` (kIo).
void WriteVtpSeries(const PointTracks& tracks, const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FORMATS_VTP_FILE_H_
