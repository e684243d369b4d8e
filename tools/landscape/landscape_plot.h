// Pictures of a scan: landscape.html, a page by itself that any browser opens, and landscape.png.
#ifndef CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_PLOT_H_
#define CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_PLOT_H_

#include <string>

#include "identify/landscape/landscape_folder.h"
#include "tools/landscape/landscape_summary.h"

namespace clothid {

// The text of landscape.html: settings side by side, windows below each other, map and surface of each, with the lowest
// cell, the truth of `landscape --set`, cells that failed, contact frequency and roughness. It looks like report.html
// and fits a phone. One file: the plotting library is inside, no address of a server is asked for
// anything, and its Content-Security-Policy lets no browser do so. Whatever names hold is shown, never run.
std::string LandscapeHtml(const LandscapePart& part, const LandscapeSummary& summary);

struct LandscapePictures {
  std::string html, png;  // their paths; an empty one was not written
  std::string note;       // why landscape.png was not written, one line for stderr; empty: it was
};

// Writes both into `folder`, which holds landscape.csv and summary.json of this very landscape. The PNG is drawn by
// tools/plots/plot_landscape, whose text this library holds, with the python3 on the path or else /usr/bin/python3;
// where none has matplotlib it is left out, and an older one is removed. Throws `Error` (kIo) where the HTML cannot be
// written.
LandscapePictures PlotLandscape(const LandscapePart& part, const LandscapeSummary& summary, const std::string& folder);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_PLOT_H_
