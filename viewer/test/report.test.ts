import { expect, test } from "vitest";
import { reportLine, reportLines } from "../src/report";

test("a report is a line and a table, of what it has", () => {
  const report = { estimated_error: 0.0189, patches: 4812, emitted: [1, 2], bands: ["R", "G"], escaped: [0, 0], rays: 0 };
  expect(reportLine(report, "3.2 s")).toBe("1.9 % estimated error, 4,812 patches, 3.2 s");
  expect(reportLine({}, "")).toBe("");
  expect(reportLines(report)).toEqual([
    ["Estimated error", "1.9 % of the mean irradiance"], ["Emitted", "R 1.00, G 2.00 W"], ["Patches", "4,812"],
  ]);
  expect(reportLines({})).toEqual([]);
});
