// What a solve says about itself, line by line, as python/radiosity/report.py prints it.

import { figures, percent, whole } from "./figures";

export type Report = Record<string, unknown>;

/** Label and text of each line that the report has something for. */
export function reportLines(report: Report): [string, string][] {
  const number = (name: string) => (typeof report[name] === "number" ? (report[name] as number) : NaN);
  const share = (name: string) => percent(number(name));
  const powers = (name: string) => {
    const values = Array.isArray(report[name]) ? (report[name] as number[]) : [];
    const bands = Array.isArray(report.bands) ? (report.bands as string[]) : [];
    return values.some((value) => value !== 0)
      ? `${values.map((value, k) => `${bands[k] ?? ""} ${figures(value)}`.trim()).join(", ")} W`
      : "";
  };
  const lines: [string, string, boolean?][] = [
    ["Estimated error", `${share("estimated_error")} of the mean irradiance`],
    ["Asked for", share("accuracy")],
    ["of it by sampling", share("sampling_error")],
    ["by patch size", share("discretisation_error")],
    ["by the mesh", share("mesh_error"), number("mesh_error") > 0 && report.of_field === true],
    ["Emitted", powers("emitted")],
    ["Arrived from lights", powers("from_lights")],
    ["Absorbed", powers("absorbed")],
    ["Escaped", powers("escaped")],
    ["Lost on backs", powers("lost_on_backs")],
    ["Energy imbalance", percent(Math.abs(number("imbalance")))],
    ["Transport", String(report.transport ?? "")],
    ["Patches", whole(number("patches"))],
    ["Meshes", whole(number("meshes")), number("meshes") > 0],
    ["Rays", `${whole(number("rays"))} + ${whole(number("shadow_rays"))} to lamps`, number("rays") > 0],
    ["Solver", solver(report)],
    ["Seconds", figures(number("seconds")), number("seconds") > 0],
  ];
  return lines
    .filter(([, text, isPresent = true]) => isPresent && text && !/^(unknown|NaN|–)/.test(text))
    .map(([label, text]) => [label, text]);
}

/** The same in one line: "1.9 % estimated error, 4,812 patches, 3.2 s"; empty where there is no report. */
export function reportLine(report: Report, duration: string): string {
  const { estimated_error: error, patches } = report;
  return [
    typeof error === "number" && `${percent(error)} estimated error`,
    typeof patches === "number" && `${whole(patches)} patches`,
    duration,
  ]
    .filter(Boolean)
    .join(", ");
}

function solver({ solver, iterations, converged }: Report): string {
  if (typeof solver !== "string" || typeof iterations !== "number") return "";
  return `${solver.replaceAll("_", " ")}, ${whole(iterations)} iterations${converged === false ? ", not converged" : ""}`;
}
