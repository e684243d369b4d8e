// How an obstacle moved, from points that were followed on it: markers of a rigid body, or all vertices of a mesh.
// Internal to datasets/importing.
#ifndef CLOTHID_DATASETS_IMPORTING_BODY_TRACKS_H_
#define CLOTHID_DATASETS_IMPORTING_BODY_TRACKS_H_

#include <Eigen/Core>
#include <string>

#include "datasets/formats/point_tracks.h"
#include "sim/obstacle/surface_sequence.h"
#include "sim/path/rigid_path.h"

namespace clothid {

// Whether `path` names tracks of all vertices of a body: a folder, .npy, .pc2, .obj or .ply.
bool IsBodySequence(const std::string& path);
// Whether it names markers: .trc.
bool IsMarkerFile(const std::string& path);

// The path of the body that `markers`, in m and with times, are on. Its pose at the first frame is the identity: the
// scene gives the shape of the body where it is then. A pose is the rigid motion, in the sense of least squares, that
// takes those markers which the first frame shows to where the frame has them; a frame that shows fewer than three of
// them, or all on a line, is left out. Throws `Error` (kBadData), led by the name of `markers`, where the first frame
// is such a one, and where a frame has markers that are off a rigid body by more than a tenth of its size.
RigidPath PathOfMarkers(const PointTracks& markers);

// The sequence of `surface` that `tracks` of its vertices, in m, are. Where they know no times, and there are as many
// as `frame_times` [T] s, those are theirs less `time_shift` s. Throws `Error`, led by the name of `tracks`: kUsage
// where times are missing, kBadData for another number of vertices or other triangles, and where SurfaceSequence does.
SurfaceSequence SequenceOfVertices(const PointTracks& tracks, const TriangulatedSurface& surface,
                                   const Eigen::VectorXd& frame_times, double time_shift);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_IMPORTING_BODY_TRACKS_H_
