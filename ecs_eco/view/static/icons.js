// Icons of the time controls.

export const PLAY = '<svg viewBox="0 0 16 16" aria-hidden="true"><path d="M4.5 2.5v11l9-5.5z"/></svg>';
export const PAUSE = '<svg viewBox="0 0 16 16" aria-hidden="true"><path d="M3.5 2.5h3v11h-3zM9.5 2.5h3v11h-3z"/></svg>';
export const BACK = '<svg viewBox="0 0 16 16" aria-hidden="true"><path d="M13 2.5v11L6 8zM5 2.5H2.5v11H5z"/></svg>';
export const STEP = '<svg viewBox="0 0 16 16" aria-hidden="true"><path d="M3 2.5v11L10 8zM11 2.5h2.5v11H11z"/></svg>';
