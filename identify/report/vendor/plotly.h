// The plotting library for pages that a browser opens.
#ifndef CLOTHID_IDENTIFY_VENDOR_PLOTLY_H_
#define CLOTHID_IDENTIFY_VENDOR_PLOTLY_H_

#include <string_view>

namespace clothid {

// The text of plotly.min.js (see README.md), to stand in a <script> of the page: then there is `Plotly`. Traces:
// scatter, heatmap, contour, surface, mesh3d, scatter3d.
std::string_view PlotlyLibrary();

// The text of plotly.LICENSES.txt: what a copy of the library has to carry along.
std::string_view PlotlyLicences();

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_VENDOR_PLOTLY_H_
