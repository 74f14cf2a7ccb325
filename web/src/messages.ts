/** What the page and its workers say to each other. */

/** Options by their names on the command line, and the preset that they change. */
export type Settings = Record<string, unknown> & { preset?: string | null };

/** A mask of the focus: a byte a pixel, light where facets are to be small. */
export interface Mask {
  width: number;
  height: number;
  weights: Uint8Array;
}

export interface Preset {
  name: string;
  about: string;
  options: Settings;
}

/** What the engine offers. */
export interface Described {
  version: string;
  defaults: Settings;
  presets: Preset[];
  choices: Record<string, (string | null)[]>;
}

/** What is known of a clip. */
export interface Clip {
  width: number;
  height: number;
  /** Seconds; 0 where it is not known. */
  duration: number;
  codec: string | null;
  decodable: boolean;
  sound: string | null;
}

/** What is known of an animation: how long each frame is shown, in milliseconds. */
export interface Animation {
  width: number;
  height: number;
  delays: number[];
  /** 0 for ever. */
  plays: number;
}

/** A picture that was rendered. */
export interface Rendered {
  width: number;
  height: number;
  points: number;
  triangles: number;
  /** Time in the engine, in milliseconds. */
  milliseconds: number;
  picture: ImageBitmap;
  /** The source, where the page does not have it. */
  source?: ImageBitmap;
}

/** Where a face is, as shares of the picture's width and height. */
export interface Face {
  left: number;
  top: number;
  width: number;
  height: number;
}

export interface RenderJob {
  settings: Settings;
  mask: Mask | null;
  /** The size of the picture itself; what is rendered may be smaller. */
  width: number;
  height: number;
  /** Sides of what is rendered are at most this long. */
  most: number;
  /** Whether the frame goes on from the one before. */
  goesOn: boolean;
  /** Whether it is drawn again soon, with all refinement. */
  isDraft: boolean;
  /** Nothing: the last one again. A number: that frame of the open animation. */
  frame: VideoFrame | ImageBitmap | number | null;
}

export type Format = 'png' | 'svg' | 'gif' | 'apng' | 'mp4' | 'webm' | 'polyreel';

export interface ExportJob {
  settings: Settings;
  mask: Mask | null;
  format: Format;
  /** Longest side, 0 for the source's own. */
  most: number;
  /** How many times as large the picture is drawn from the mesh. */
  times: number;
  title: string;
  /** What is exported: a file, or one picture. */
  source:
    | { kind: 'clip'; file: Blob }
    | { kind: 'animation'; file: Blob; type: string }
    | { kind: 'still'; frame: ImageBitmap | VideoFrame };
}

export interface Jobs {
  describe: { job: null; result: Described };
  openClip: { job: Blob; result: Clip };
  openAnimation: { job: { file: Blob; type: string }; result: Animation | null };
  render: { job: RenderJob; result: Rendered };
  thumbnail: { job: RenderJob; result: Rendered };
  faces: { job: ImageBitmap | VideoFrame; result: Face[] };
  presetFile: { job: { settings: Settings; mask: Mask | null }; result: string };
  readPresetFile: { job: string; result: Settings };
  commandLine: {
    job: { settings: Settings; input: string; output: string; more: string };
    result: string;
  };
  codecs: { job: { width: number; height: number }; result: { mp4: string | null; webm: string | null } };
  export: { job: ExportJob; result: { file: Blob; frames: number; remark: string } };
}

export type Job = keyof Jobs;

export interface Request<J extends Job = Job> {
  number: number;
  name: J;
  job: Jobs[J]['job'];
}

export type Reply =
  | { number: number; result: unknown }
  | { number: number; error: string }
  | { number: number; progress: number; frame: number };
