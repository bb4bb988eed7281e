// Pictures on buttons, 24 x 24, drawn with a line.

const PATHS = {
  orbit: "M12 9.5a2.5 2.5 0 1 0 0 5 2.5 2.5 0 0 0 0-5M20.5 8.5C22 11 18.500 15.500 13 17.500S3.500 18 3.500 15.500 6.500 9.500 12 7.300s8.500-.8 8.500 1.200",
  walk: "M13 4.200a1.300 1.300 0 1 0 0-.1M9 20.500l2.500-5.500 2.500 2v4M11.500 15l.8-6L9 10.500 8 13.500M12.300 9l2 2.500 3 1",
  fly: "M3 12.500l18-8-6 16-3.500-6.500zM11.500 14L21 4.500",
  home: "M4 11.500L12 4.500l8 7M6.500 9.800v9.700h4v-5.500h3v5.500h4V9.800",
  picture: "M4 8h3.500L9 5.500h6L16.500 8H20v11H4zM12 10a3.300 3.300 0 1 0 0 6.600 3.300 3.300 0 0 0 0-6.600",
  link: "M10 14a4 4 0 0 0 6 .4l2.800-2.800a4 4 0 0 0-5.600-5.700l-1.200 1.200M14 10a4 4 0 0 0-6-.4l-2.800 2.800a4 4 0 0 0 5.600 5.700l1.200-1.200",
  full: "M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5",
  hide: "M3 3l18 18M9.900 5.300A9.500 9.500 0 0 1 12 5c6 0 9 7 9 7a16 16 0 0 1-2.600 3.600M6.200 6.800C4.100 8.600 3 12 3 12s3 7 9 7a9 9 0 0 0 4.200-1.100M10 10a2.800 2.800 0 0 0 4 4",
  help: "M9 9a3 3 0 1 1 4.300 2.700c-.9.500-1.300 1-1.300 2.300M12 17.500v.1M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18",
  panels: "M4 5h16v14H4zM14.500 5v14",
};

export type Icon = keyof typeof PATHS;

const SVG = "http://www.w3.org/2000/svg";

export function icon(name: Icon): SVGSVGElement {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("class", "icon");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS(SVG, "path");
  path.setAttribute("d", PATHS[name]);
  svg.append(path);
  return svg;
}
